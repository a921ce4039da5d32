// The table compiled into the program holds every shader file, byte for byte, and nothing else.
#include "check.h"

#include <ftw.h>
#include <sys/stat.h>

#include "gpu/embedded.h"

static int found, missing;

static const char *embedded_text(const char *name)
{
    for (const struct embedded_file *f = embedded_files; f->name; f++)
        if (strcmp(f->name, name) == 0) return f->text;
    return NULL;
}

static int compare_file(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    const char *base = path + where->base;
    size_t length = strlen(base);
    if (kind != FTW_F || base[0] == '.' || base[0] == '#' || base[length - 1] == '~') return 0;
    found++;
    const char *text = embedded_text(path + strlen(PROJECT_SHADER_DIR) + 1);
    size_t size = (size_t)info->st_size;
    char *want = malloc(size + 1);
    FILE *file = fopen(path, "rb");
    assert_non_null(want);
    assert_non_null(file);
    assert_int_equal(fread(want, 1, size, file), size);
    fclose(file);
    if (!text || strlen(text) != size || memcmp(text, want, size) != 0) {
        print_error("%s is %s\n", path, text ? "embedded in another state" : "not embedded");
        missing++;
    }
    free(want);
    return 0;
}

static void test_every_file(void **state)
{
    (void)state;
    int count = 0;
    for (const struct embedded_file *f = embedded_files; f->name; f++) count++;
    assert_int_equal(nftw(PROJECT_SHADER_DIR, compare_file, 8, 0), 0);
    print_message("%d shader files\n", found);
    assert_true(found > 0);
    assert_int_equal(missing, 0);
    assert_int_equal(count, found);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_file)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
