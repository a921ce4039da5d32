# One static library a room: perigee_room(geo base) makes perigee_geo from src/geo/*.c, which may use base only.

add_library(perigee_flags INTERFACE)
target_compile_definitions(perigee_flags INTERFACE _GNU_SOURCE)
target_compile_options(perigee_flags INTERFACE
    $<$<COMPILE_LANGUAGE:C>:-Wall;-Wextra;-Wshadow;-Wstrict-prototypes;-Wmissing-prototypes;-Wvla;-ffp-contract=off>
    $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra>
    $<$<BOOL:${PERIGEE_WERROR}>:-Werror>)
if(PERIGEE_SANITIZE)
    target_compile_options(perigee_flags INTERFACE -fsanitize=${PERIGEE_SANITIZE}
        -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(perigee_flags INTERFACE -fsanitize=${PERIGEE_SANITIZE})
endif()

function(perigee_room name)
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.c ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
    add_library(perigee_${name} STATIC ${sources})
    target_include_directories(perigee_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/shaders)
    target_link_libraries(perigee_${name} PRIVATE perigee_flags PUBLIC m)
    foreach(room ${ARGN})
        target_link_libraries(perigee_${name} PUBLIC perigee_${room})
    endforeach()
endfunction()
