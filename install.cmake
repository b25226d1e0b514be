# What `cmake --install` puts where: the command and its manual page, the libraries with their public headers, a
# pkg-config file and a CMake package. Each finds the rest relative to itself, so that an installed
# tree can be moved.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(RK_HEADERS ${CMAKE_INSTALL_INCLUDEDIR}/sand-reckoner) # "base/error.h" is found from here
set(RK_PACKAGE ${CMAKE_INSTALL_LIBDIR}/cmake/SandReckoner)
set(RK_LIBRARIES rk_ensemble rk_cases rk_engine rk_stats rk_base) # users before what they use

install(TARGETS reckon RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${PROJECT_BINARY_DIR}/ensemble/reckon.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(TARGETS ${RK_LIBRARIES} EXPORT SandReckoner
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  INCLUDES DESTINATION ${RK_HEADERS})

file(GLOB base_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/base/*.h)
install(FILES ${base_headers} DESTINATION ${RK_HEADERS}/base)
set(stats_headers
  blocking correlation data forces histogram ldf ldf_compare ldf_direct ldf_limit ldf_symmetry
  moments pdf rate relax resample resonance rise_time spectrum spread stats stein units)
list(TRANSFORM stats_headers REPLACE "(.+)" "stats/\\1.h")
foreach(header engine/engine.h engine/spec.h cases/cases.h ${stats_headers} ensemble/study.h ensemble/store.h
        ensemble/runner.h ensemble/analysis.h)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${RK_HEADERS}/${folder})
endforeach()

# ---- The CMake package: find_package(SandReckoner), SandReckoner::rk_engine and the others ------

install(EXPORT SandReckoner FILE SandReckonerTargets.cmake NAMESPACE SandReckoner::
  DESTINATION ${RK_PACKAGE})
file(CONFIGURE OUTPUT SandReckonerConfig.cmake @ONLY CONTENT [[
include(CMakeFindDependencyMacro)
find_dependency(PkgConfig)
find_dependency(OpenMP COMPONENTS C)
find_dependency(HDF5 COMPONENTS C)
if(@RK_MPI_FOUND@)
  find_dependency(MPI COMPONENTS C)
endif()
pkg_check_modules(FFTW QUIET IMPORTED_TARGET fftw3)
pkg_check_modules(GSL QUIET IMPORTED_TARGET gsl)
pkg_check_modules(YAML QUIET IMPORTED_TARGET yaml-0.1)
pkg_check_modules(XXHASH QUIET IMPORTED_TARGET libxxhash)
foreach(need FFTW GSL YAML XXHASH)
  if(NOT ${need}_FOUND)
    set(SandReckoner_FOUND FALSE)
    set(SandReckoner_NOT_FOUND_MESSAGE "pkg-config does not find the library of ${need}")
    return()
  endif()
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/SandReckonerTargets.cmake)
]])
write_basic_package_version_file(${PROJECT_BINARY_DIR}/SandReckonerConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/SandReckonerConfig.cmake
  ${PROJECT_BINARY_DIR}/SandReckonerConfigVersion.cmake DESTINATION ${RK_PACKAGE})

# ---- pkg-config: the libraries are static, so whoever links them needs what they need -----------

list(TRANSFORM RK_LIBRARIES PREPEND "-l" OUTPUT_VARIABLE pc_links)
set(pc_hdf5 ${HDF5_C_LIBRARIES})
list(FILTER pc_hdf5 INCLUDE REGEX hdf5) # and not what a shared HDF5 needs in its turn
if(RK_MPI_FOUND)
  list(APPEND pc_hdf5 ${MPI_C_LIBRARIES})
endif()
list(APPEND pc_links ${pc_hdf5} ${OpenMP_C_FLAGS} -lm)
list(JOIN pc_links " " pc_links)
file(RELATIVE_PATH pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_prefix ${pc_prefix})
file(CONFIGURE OUTPUT sand-reckoner.pc @ONLY CONTENT [[
prefix=${pcfiledir}/@pc_prefix@
libdir=${prefix}/@CMAKE_INSTALL_LIBDIR@
includedir=${prefix}/@RK_HEADERS@

Name: Sand Reckoner
Description: @PROJECT_DESCRIPTION@
Version: @PROJECT_VERSION@
Requires: fftw3 gsl yaml-0.1 libxxhash
Cflags: -I${includedir}
Libs: -L${libdir} @pc_links@
]])
install(FILES ${PROJECT_BINARY_DIR}/sand-reckoner.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
