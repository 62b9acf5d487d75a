#!/bin/sh
# Compiles through ccache. Usage: docker/ccache.sh CCACHE COMPILER ARGUMENT...
# Beside a precompiled header it writes the header's sum, which ccache then reads in place of the header itself: 300 MB
# for each compilation. The header that is replaced is removed first: ccache's preprocessor would read it in place of the
# sources that have changed, and ccache would return it again.
set -eu
export CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_PCH_EXTSUM=1
for argument in "$@"; do
  case $argument in
    *.gch) rm -f "$argument" ;;
  esac
done
"$@"
for argument in "$@"; do
  case $argument in
    *.gch) sha256sum <"$argument" >"$argument.sum" && break ;;
  esac
done
