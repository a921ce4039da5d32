# perigee_embed(target DIR): compiles every file under DIR (but hidden files and editors' backups) into the target as a
# table of names and texts (src/gpu/embedded.h). New, changed and removed files are seen by the next build.
function(perigee_embed target dir)
    file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE ${dir} ${dir}/*)
    list(FILTER files EXCLUDE REGEX "(^|/)[.#]|~$")
    list(SORT files)
    set(out ${CMAKE_CURRENT_BINARY_DIR}/${target}_embedded.c)
    set(paths "")
    foreach(f ${files})
        list(APPEND paths ${dir}/${f})
    endforeach()
    add_custom_command(OUTPUT ${out}
        COMMAND ${CMAKE_COMMAND} -DOUT=${out} -DDIR=${dir} "-DFILES=${files}" -P ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake
        DEPENDS ${paths} ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake VERBATIM)
    target_sources(${target} PRIVATE ${out})
endfunction()
