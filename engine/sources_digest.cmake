# Writes a header with a digest of the engine's sources: of the name and the content of every file that is compiled or
# included. Other files, as this one and the pages in Markdown, do not change it.
#
#   cmake -DENGINE=FOLDER -DOUTPUT=HEADER -P sources_digest.cmake
file(GLOB_RECURSE sources RELATIVE ${ENGINE} ${ENGINE}/*.cc ${ENGINE}/*.h ${ENGINE}/*.cc.in ${ENGINE}/*.inc)
list(SORT sources)
set(sums)
foreach(source ${sources})
  file(SHA256 ${ENGINE}/${source} sum)
  string(APPEND sums "${sum} ${source}\n")
endforeach()
string(SHA256 digest "${sums}")
string(SUBSTRING ${digest} 0 16 digest)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define STIEFEL_SOURCES_DIGEST \"${digest}\"\n")
