// The shader loader: includes, line numbers, messages, defines, the live folder.
#include "check.h"

#include <stdbool.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"
#include "gpu/gpu_fixture.h"
#include "gpu/program.h"

#define MAIN_IS(value)                                                                             \
    "layout(local_size_x = 1) in;\n"                                                               \
    "layout(std430, binding = 0) buffer Result { int result; };\n"                                 \
    "void main() { result = " value "; }\n"

static char folder[] = "gpu_program_XXXXXX";

static void write_file(const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static void make_folder(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0700), 0);
}

// Compiles "main.comp" and gives what it writes.
static int run(const char *defines)
{
    GLuint program = 0, buffer = 0;
    int result = -1;
    assert_int_equal(gpu_program_create_compute("main.comp", defines, &program), OK);
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, sizeof result, &result, 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
    glUseProgram(program);
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffer, 0, sizeof result, &result);
    glUseProgram(0);
    glDeleteProgram(program);
    glDeleteBuffers(1, &buffer);
    return result;
}

static void check_fails(status want, const char *words, const char *more)
{
    GLuint program = 1;
    status got = gpu_program_create_compute("main.comp", NULL, &program);
    gpu_fixture_forgive();
    const char *line = log_last_error();
    if (got != want || !strstr(line, words) || !strstr(line, more))
        fail_msg("got %d '%s', want %d with '%s' and '%s'", got, line, want, words, more);
    assert_int_equal(program, 0);
}

static void test_each_file_once(void **state)
{
    (void)state;
    write_file("lib/one.glsl", "int one() { return 1; }\n");
    write_file("lib/two.glsl", "#include \"lib/one.glsl\"\nint two() { return one() + one(); }");
    write_file("main.comp", "#include \"lib/one.glsl\"\n  #  include \"lib/two.glsl\"\n"
                            "#include \"lib/two.glsl\"\n" MAIN_IS("one() + two()"));
    assert_int_equal(run(NULL), 3);
}

// The first to name the file stands in a group that is left out: the second must count.
static void test_include_left_out(void **state)
{
    (void)state;
    write_file("main.comp", "#ifdef NEVER\n#include \"lib/one.glsl\"\n#endif\n"
                            "#include \"lib/one.glsl\"\n" MAIN_IS("one()"));
    assert_int_equal(run(NULL), 1);
    assert_int_equal(run("#define NEVER\n"), 1);
}

static void test_files_that_include_each_other(void **state)
{
    (void)state;
    write_file("lib/a.glsl", "#include \"lib/b.glsl\"\nint a() { return b() + 1; }\n");
    write_file("lib/b.glsl", "#include \"lib/a.glsl\"\nint b() { return 4; }\n");
    write_file("main.comp", "#include \"lib/a.glsl\"\n#include \"main.comp\"\n" MAIN_IS("a()"));
    assert_int_equal(run(NULL), 5);
}

static void test_defines(void **state)
{
    (void)state;
    write_file("main.comp", MAIN_IS("VALUE * 2"));
    assert_int_equal(run("#define VALUE 21\n"), 42);
    assert_int_equal(run("#define VALUE 4"), 8);
    check_fails(ERR_GPU, "main.comp:3", "VALUE");
}

static void test_dos_lines(void **state)
{
    (void)state;
    write_file("main.comp", "#include \"lib/one.glsl\"\r\n" MAIN_IS("one()"));
    assert_int_equal(run(NULL), 1);
}

static void test_error_names_file_and_line(void **state)
{
    (void)state;
    write_file("lib/bad.glsl", "#include \"lib/one.glsl\"\n\nint bad() { return nothing; }\n");
    write_file("main.comp", "// first\n#include \"lib/bad.glsl\"\n" MAIN_IS("bad()"));
    check_fails(ERR_GPU, "lib/bad.glsl:3", "nothing");
    write_file("main.comp",
               "#include \"lib/two.glsl\"\nint f() { return missing; }\n" MAIN_IS("1"));
    check_fails(ERR_GPU, "main.comp:2", "missing");
    write_file("main.comp", "#ifdef NEVER\n#include \"lib/two.glsl\"\n#endif\nint g() { return "
                            "missing; }\n" MAIN_IS("1"));
    check_fails(ERR_GPU, "main.comp:4", "missing");
}

static void test_missing_files(void **state)
{
    (void)state;
    write_file("main.comp", "\n#include \"lib/absent.glsl\"\n" MAIN_IS("1"));
    check_fails(ERR_NOT_FOUND, "main.comp:2", "lib/absent.glsl");
    GLuint program = 1;
    assert_int_equal(gpu_program_create_compute("gone.comp", NULL, &program), ERR_NOT_FOUND);
    assert_int_equal(program, 0);
    assert_non_null(strstr(log_last_error(), "gone.comp"));
    assert_non_null(strstr(log_last_error(), folder));
    write_file("main.comp", "#include \"lib\"\n" MAIN_IS("1"));
    check_fails(ERR_IO, "main.comp:1", "lib");
}

static void test_malformed_includes(void **state)
{
    (void)state;
    const char *const lines[] = {"#include", "#include <x>", "#include \"x", "#include \"\""};
    for (int i = 0; i < 4; i++) {
        char text[64];
        snprintf(text, sizeof text, "\n\n%s\n", lines[i]);
        write_file("main.comp", text);
        check_fails(ERR_FORMAT, "main.comp:3", "#include");
    }
}

static void test_too_many_includes(void **state)
{
    (void)state;
    enum { CHAIN = 20, WIDE = 100 };
    char name[64], text[WIDE * 64] = "";
    for (int i = 0; i < CHAIN; i++) {
        snprintf(name, sizeof name, "deep/%d.glsl", i);
        snprintf(text, sizeof text, "#include \"deep/%d.glsl\"\n", i + 1);
        write_file(name, text);
    }
    write_file("main.comp", "#include \"deep/0.glsl\"\n");
    check_fails(ERR_FORMAT, "too many or too deep", "deep/");
    size_t size = 0;
    for (int i = 0; i < WIDE; i++) {
        snprintf(name, sizeof name, "deep/%d.glsl", i);
        write_file(name, "\n");
        size += (size_t)snprintf(text + size, sizeof text - size, "#include \"%s\"\n", name);
    }
    write_file("main.comp", text);
    check_fails(ERR_FORMAT, "too many or too deep", "main.comp");
}

static void test_endless_file(void **state)
{
    (void)state;
    size_t size = (size_t)5 << 20;
    char *text = malloc(size + 1);
    assert_non_null(text);
    memset(text, '\n', size);
    text[size] = 0;
    write_file("main.comp", text);
    free(text);
    check_fails(ERR_IO, "main.comp", "unreadable");
}

static void test_link_error_names_both(void **state)
{
    (void)state;
    write_file("a.vert", "out vec4 shade;\nvoid main() { shade = gl_Position = vec4(0.0); }\n");
    write_file("a.frag", "in vec3 shade;\nout vec4 c;\nvoid main() { c = vec4(shade, 1.0); }\n");
    GLuint program = 1;
    assert_int_equal(gpu_program_create_render("a.vert", "a.frag", NULL, &program), ERR_GPU);
    gpu_fixture_forgive();
    assert_int_equal(program, 0);
    assert_non_null(strstr(log_last_error(), "a.vert + a.frag"));
    assert_non_null(strstr(log_last_error(), "shade"));
}

static void test_folder_is_live(void **state)
{
    (void)state;
    write_file("main.comp", MAIN_IS("1"));
    assert_int_equal(run(NULL), 1);
    write_file("main.comp", MAIN_IS("2"));
    assert_int_equal(run(NULL), 2);
    gpu_program_set_dir(NULL);
    check_fails(ERR_NOT_FOUND, "main.comp", "built-in");
    gpu_program_set_dir(folder);
}

static int open_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) return -1;
    make_folder("lib");
    make_folder("deep");
    gpu_program_set_dir(folder);
    return 0;
}

static int close_folder(void **state)
{
    (void)state;
    char command[64];
    gpu_program_set_dir(NULL);
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_file_once),
        cmocka_unit_test(test_include_left_out),
        cmocka_unit_test(test_files_that_include_each_other),
        cmocka_unit_test(test_defines),
        cmocka_unit_test(test_dos_lines),
        cmocka_unit_test(test_error_names_file_and_line),
        cmocka_unit_test(test_missing_files),
        cmocka_unit_test(test_malformed_includes),
        cmocka_unit_test(test_too_many_includes),
        cmocka_unit_test(test_endless_file),
        cmocka_unit_test(test_link_error_names_both),
        cmocka_unit_test(test_folder_is_live),
    };
    int rc = gpu_fixture_open();
    if (rc) return rc;
    return gpu_fixture_close(cmocka_run_group_tests(tests, open_folder, close_folder));
}
