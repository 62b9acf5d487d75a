# stiefel_embed(TARGET NAME FILE...) makes the texts of files part of a target:
# `std::span<const stiefel::cli::EmbeddedFile> stiefel::cli::NAME()` of client/cli/input/embedded.h has their names and
# texts. A file that changes is embedded again by the next build.
#
# As a script, `cmake -P embed.cmake OUTPUT NAME FILE...` writes the source that defines this function.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(STIEFEL_EMBED ${CMAKE_CURRENT_LIST_FILE})
  function(stiefel_embed target name)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/embedded_${name}.cc)
    add_custom_command(
      OUTPUT ${source}
      COMMAND ${CMAKE_COMMAND} -P ${STIEFEL_EMBED} ${source} ${name} ${ARGN}
      DEPENDS ${ARGN} ${STIEFEL_EMBED} VERBATIM)
    target_sources(${target} PRIVATE ${source})
  endfunction()
  return()
endif()

set(entries)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(k RANGE 5 ${last})
  get_filename_component(name ${CMAKE_ARGV${k}} NAME)
  file(READ ${CMAKE_ARGV${k}} text)
  string(APPEND entries "      {\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE ${CMAKE_ARGV3} "#include \"client/cli/input/embedded.h\"

namespace stiefel::cli {

std::span<const EmbeddedFile> ${CMAKE_ARGV4}() {
  static constexpr EmbeddedFile files[] = {
${entries}  };
  return files;
}

}  // namespace stiefel::cli
")
