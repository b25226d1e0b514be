#!/bin/sh
# check.sh RECKON CASE [--write]: run the commands of a case, compare what they print.
#
# A case is a text file. A line "$ command" is carried out by sh in a fresh copy of data/, with
# `reckon` on its path; the lines after it, up to the next "$ ", are what it must print: standard
# output, then standard error with "! " before each line, then "= code" when the exit code is not
# 0. Lines that begin with "# " before the first command are comments. With --write the case is
# written anew from what the commands print; read the difference before you believe it.
set -u
reckon=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
case=$(cd "$(dirname "$2")" && pwd)/$(basename "$2")
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin" "$work/home" && ln -s "$reckon" "$work/bin/reckon" && cp -R "$here/data" "$work/data" || exit 1
PATH=$work/bin:$PATH
HOME=$work/home
export PATH HOME
unset NO_COLOR OMP_NUM_THREADS
cd "$work/data" || exit 1

while IFS= read -r line; do
  case $line in
    "# "*) [ -e "$work/begun" ] || printf '%s\n' "$line" >> "$work/got" ;;
    "\$ "*)
      : > "$work/begun"
      printf '%s\n' "$line" >> "$work/got"
      (eval "${line#\$ }") > "$work/out" 2> "$work/err" < /dev/null
      code=$?
      cat "$work/out" >> "$work/got"
      sed 's/^/! /' "$work/err" >> "$work/got"
      [ $code -eq 0 ] || echo "= $code" >> "$work/got" ;;
  esac
done < "$case"

if [ "${3:-}" = --write ]; then
  cp "$work/got" "$case"
else
  diff -u "$case" "$work/got"
fi
