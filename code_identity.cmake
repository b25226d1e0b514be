# cmake -DROOT=... -DFILES=... -DVERSION=... -DOUT=... -P code_identity.cmake
# Write a header that names the code which decides the bytes of a run: the version, and a digest of
# the sources of base, engine and cases. Two builds of the same sources have the same name.
cmake_minimum_required(VERSION 3.25)
set(all "")
foreach(file ${FILES})
  file(SHA256 ${file} digest)
  file(RELATIVE_PATH name ${ROOT} ${file})
  string(APPEND all "${name} ${digest}\n")
endforeach()
string(SHA256 digest "${all}")
string(SUBSTRING ${digest} 0 12 digest)
file(CONFIGURE OUTPUT ${OUT} CONTENT
  "/* Made by code_identity.cmake. */\n#define RK_CODE \"@VERSION@+@digest@\"\n" @ONLY)
