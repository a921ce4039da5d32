// The uniform blocks: every member of the C structs lies where GL puts it, with the type that the
// shaders give it.
#include "check.h"

#include "gpu/gpu_fixture.h"
#include "gpu/program.h"
#include "render/blocks.h"

struct member {
    const char *name;
    size_t offset;
    GLint type, count, matrix_stride; // stride 0: no matrix
};

#define BLOCK_MEMBER(name, type, count, stride)                                                    \
    {BLOCK_NAME "." #name, offsetof(struct BLOCK_STRUCT, name), type, count, stride},
#define BLOCK_MAT4(name)              BLOCK_MEMBER(name, GL_FLOAT_MAT4, 1, 16)
#define BLOCK_VEC4(name)              BLOCK_MEMBER(name, GL_FLOAT_VEC4, 1, 0)
#define BLOCK_UVEC4(name)             BLOCK_MEMBER(name, GL_UNSIGNED_INT_VEC4, 1, 0)
#define BLOCK_VEC4_ARRAY(name, count) BLOCK_MEMBER(name, GL_FLOAT_VEC4, count, 0)

#define BLOCK_NAME   "View"
#define BLOCK_STRUCT view_block
static const struct member view_members[] = {
#include "shared/view_block.glsl"
};
#undef BLOCK_NAME
#undef BLOCK_STRUCT

#define BLOCK_NAME   "Levels"
#define BLOCK_STRUCT levels_block
static const struct member levels_members[] = {
#include "shared/levels_block.glsl"
};

enum { PROPERTIES = 6 };

static void check_member(GLuint program, const struct member *m)
{
    const GLenum wanted[PROPERTIES] = {GL_OFFSET,       GL_TYPE,          GL_ARRAY_SIZE,
                                       GL_ARRAY_STRIDE, GL_MATRIX_STRIDE, GL_IS_ROW_MAJOR};
    GLint got[PROPERTIES] = {-1, -1, -1, -1, -1, -1};
    GLuint index = glGetProgramResourceIndex(program, GL_UNIFORM, m->name);
    if (index == GL_INVALID_INDEX) {
        char element[128];
        snprintf(element, sizeof element, "%s[0]", m->name);
        index = glGetProgramResourceIndex(program, GL_UNIFORM, element);
    }
    if (index == GL_INVALID_INDEX) fail_msg("the shaders have no %s", m->name);
    glGetProgramResourceiv(program, GL_UNIFORM, index, PROPERTIES, wanted, PROPERTIES, NULL, got);
    if (got[0] != (GLint)m->offset || got[1] != m->type || got[2] != m->count ||
        (m->count > 1 && got[3] != 16) || got[4] != m->matrix_stride || got[5] != 0)
        fail_msg("%s: offset %d (C %zu), type 0x%04x (C 0x%04x), %d elements (C %d) each %d bytes, "
                 "matrix stride %d, row major %d",
                 m->name, got[0], m->offset, got[1], m->type, got[2], m->count, got[3], got[4],
                 got[5]);
}

static void check_block(GLuint program, const char *name, size_t size, const struct member *members,
                        int count)
{
    const GLenum wanted[] = {GL_BUFFER_DATA_SIZE, GL_NUM_ACTIVE_VARIABLES};
    GLint got[2] = {0, 0};
    GLuint index = glGetProgramResourceIndex(program, GL_UNIFORM_BLOCK, name);
    assert_int_not_equal(index, GL_INVALID_INDEX);
    glGetProgramResourceiv(program, GL_UNIFORM_BLOCK, index, 2, wanted, 2, NULL, got);
    assert_int_equal(got[0], size);
    assert_int_equal(got[1], count);
    for (int i = 0; i < count; i++) check_member(program, &members[i]);
    print_message("%s: %d members, %zu bytes\n", name, count, size);
}

static void test_offsets(void **state)
{
    (void)state;
    GLuint program;
    gpu_program_set_dir(TEST_SHADER_DIR);
    assert_int_equal(gpu_program_create_compute("test/blocks.comp", NULL, &program), OK);
    check_block(program, "View", sizeof(struct view_block), view_members,
                (int)(sizeof view_members / sizeof *view_members));
    check_block(program, "Levels", sizeof(struct levels_block), levels_members,
                (int)(sizeof levels_members / sizeof *levels_members));
    glDeleteProgram(program);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_offsets)};
    int rc = gpu_fixture_open();
    if (rc) return rc;
    return gpu_fixture_close(cmocka_run_group_tests(tests, NULL, NULL));
}
