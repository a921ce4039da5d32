// Targets: what is read back and in which order, the reversed depth, what is refused.
#include "check.h"

#include <stdbool.h>

#include "base/log.h"
#include "gpu/gpu_fixture.h"
#include "gpu/program.h"
#include "gpu/target.h"

enum { WIDTH = 37, HEIGHT = 11 };

static GLuint program;

static void draw(const gpu_target *t, float depth, const float tint[4])
{
    glUseProgram(program);
    glProgramUniform1f(program, 0, depth);
    glProgramUniform4fv(program, 1, 1, tint);
    glBindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    glViewport(0, 0, t->width, t->height);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void test_readback_top_row_first(void **state)
{
    (void)state;
    gpu_target t;
    float place[HEIGHT][WIDTH][2];
    unsigned char color[HEIGHT][WIDTH][3];
    const float tint[4] = {1.0f, 0.0f, 0.2f, 1.0f};
    assert_int_equal(gpu_target_init(&t, WIDTH, HEIGHT, (GLenum[]){GL_RGBA8, GL_RG32F}, 2, 0), OK);
    assert_int_equal(t.depth, 0);
    draw(&t, 0.5f, tint);
    glPixelStorei(GL_PACK_ROW_LENGTH, 100); // another program's state: neither used nor lost
    glPixelStorei(GL_PACK_SKIP_ROWS, 3);
    gpu_target_read(&t, t.colors[1], GL_RG, GL_FLOAT, sizeof place[0][0], place);
    gpu_target_read(&t, t.colors[0], GL_RGB, GL_UNSIGNED_BYTE, sizeof color[0][0], color);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            check_near(place[y][x][0], x + 0.5, 0);
            check_near(place[y][x][1], HEIGHT - 1 - y + 0.5, 0);
            assert_int_equal(color[y][x][0], 255);
            assert_int_equal(color[y][x][1], 0);
            assert_int_equal(color[y][x][2], 51);
        }
    GLint alignment = 0, length = 0, skip = 0;
    glGetIntegerv(GL_PACK_ALIGNMENT, &alignment);
    glGetIntegerv(GL_PACK_ROW_LENGTH, &length);
    glGetIntegerv(GL_PACK_SKIP_ROWS, &skip);
    assert_true(alignment == 4 && length == 100 && skip == 3);
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    glPixelStorei(GL_PACK_SKIP_ROWS, 0);
    gpu_target_deinit(&t);
}

// Reversed depth near / distance: surfaces a metre apart at 2,000 km are told apart, whichever is
// drawn first; what is read back is the float itself, so distance is known to 2^-24 of itself.
static void test_reversed_depth(void **state)
{
    (void)state;
    gpu_target t;
    const float red[4] = {1, 0, 0, 1}, blue[4] = {0, 0, 1, 1};
    const double near = 0.5, far_away = 2.0e6;
    float depth[HEIGHT][WIDTH];
    float first = (float)(near / far_away), second = (float)(near / (far_away + 1.0));
    unsigned char color[HEIGHT][WIDTH][4];
    assert_int_equal(
        gpu_target_init(&t, WIDTH, HEIGHT, (GLenum[]){GL_RGBA8}, 1, GL_DEPTH_COMPONENT32F), OK);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    for (int order = 0; order < 2; order++) {
        const float zero = 0.0f;
        glClearNamedFramebufferfv(t.framebuffer, GL_DEPTH, 0, &zero);
        draw(&t, order ? second : first, order ? blue : red);
        draw(&t, order ? first : second, order ? red : blue);
        gpu_target_read(&t, t.colors[0], GL_RGBA, GL_UNSIGNED_BYTE, 4, color);
        gpu_target_read(&t, t.depth, GL_DEPTH_COMPONENT, GL_FLOAT, sizeof(float), depth);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            assert_int_equal(color[i / WIDTH][i % WIDTH][0], 255);
            assert_int_equal(color[i / WIDTH][i % WIDTH][2], 0);
            check_near(near / depth[i / WIDTH][i % WIDTH], far_away, far_away * 0x1p-23);
        }
    }
    glDisable(GL_DEPTH_TEST);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    gpu_target_deinit(&t);
}

static void test_depth_alone(void **state)
{
    (void)state;
    const GLenum formats[] = {GL_DEPTH_COMPONENT32F, GL_DEPTH24_STENCIL8, GL_DEPTH32F_STENCIL8};
    for (int i = 0; i < 3; i++) {
        gpu_target t;
        assert_int_equal(gpu_target_init(&t, WIDTH, HEIGHT, NULL, 0, formats[i]), OK);
        assert_true(t.depth != 0);
        gpu_target_deinit(&t);
        assert_int_equal(t.framebuffer, 0);
        gpu_target_deinit(&t);
    }
}

static void check_refused(int width, int height, GLenum format, const char *words)
{
    gpu_target t;
    status s = gpu_target_init(&t, width, height, &format, 1, 0);
    gpu_fixture_forgive();
    if (s != ERR_GPU || !strstr(log_last_error(), words))
        fail_msg("%d x %d: status %d, '%s'", width, height, s, log_last_error());
    assert_int_equal(t.framebuffer, 0);
    assert_int_equal(t.colors[0], 0);
}

static void test_refusals(void **state)
{
    (void)state;
    GLint most = 0;
    char size[64];
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    snprintf(size, sizeof size, "7 x %d", most + 1);
    check_refused(7, most + 1, GL_RGBA8, size);
    check_refused(0, 5, GL_RGBA8, "0 x 5");
    check_refused(5, -1, GL_RGBA8, "5 x -1");
    check_refused(5, 6, GL_RGB9_E5, "5 x 6");
    check_refused(5, 6, GL_RGBA, "5 x 6");
}

static int make_program(void **state)
{
    (void)state;
    gpu_program_set_dir(TEST_SHADER_DIR);
    return gpu_program_create_render("test/fullscreen.vert", "test/pixel.frag", NULL, &program);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_readback_top_row_first),
        cmocka_unit_test(test_reversed_depth),
        cmocka_unit_test(test_depth_alone),
        cmocka_unit_test(test_refusals),
    };
    int rc = gpu_fixture_open();
    if (rc) return rc;
    GLuint vertices;
    glCreateVertexArrays(1, &vertices);
    glBindVertexArray(vertices);
    return gpu_fixture_close(cmocka_run_group_tests(tests, make_program, NULL));
}
