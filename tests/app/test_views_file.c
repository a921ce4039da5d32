// Sets of views in JSON: what is accepted, and that each fault is one line naming the file, the
// view and the value. The shipped set loads.
#include "check.h"

#include <unistd.h>

#include "app/views_file.h"
#include "base/log.h"

static int lines;
static char last[1024];
static char file_name[] = "test_views_file-XXXXXX";

static void count_lines(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level != LOG_ERROR) return;
    lines++;
    snprintf(last, sizeof last, "%s", line);
}

static status load(const char *text, struct views_file *out)
{
    FILE *f = fopen(file_name, "w");
    assert_non_null(f);
    fputs(text, f);
    assert_int_equal(fclose(f), 0);
    lines = 0;
    return views_file_load(file_name, out);
}

#define VIEW(name, rest)                                                                           \
    "{\"name\":\"" name "\",\"lat\":45,\"lon\":10,\"heading\":0,\"pitch\":-90," rest "}"
#define FILE_OF(views) "{\"views\":[" views "]}"

static const struct {
    const char *text, *words;
} refused[] = {
    {"", "line 1: not JSON"},
    {"[]", "not a JSON object"},
    {"{}", "\"views\" is not a list of 1 to 10000"},
    {"{\"views\":[]}", "\"views\" is not a list of 1 to 10000"},
    {"{\"views\":7}", "\"views\" is not a list"},
    {"{\"views\":[],\"keys\":[]}", "\"keys\" is not a member known here"},
    {"{\"views\":[7]}", "view 1: not a JSON object"},
    {"{\"fov\":0,\"views\":[]}", "\"fov\" is 0, not in 0.01..179"},
    {FILE_OF("{\"lat\":1}"), "view 1: \"name\" is missing"},
    {FILE_OF(VIEW("", "\"alt\":1")), "view 1: \"name\" is missing or empty"},
    {FILE_OF(VIEW("a", "\"alt\":1") "," VIEW("a", "\"alt\":1")), "view 2: \"name\" is another"},
    {FILE_OF(VIEW("a", "\"alt\":1") "," VIEW("hill", "\"alt\":-4")),
     "view 2, 'hill': \"alt\" is -4, not in"},
    {FILE_OF(VIEW("hill", "\"alt\":1,\"aboveGround\":2")), "view 1, 'hill': exactly one of"},
    {FILE_OF(VIEW("hill", "\"roll\":2")), "view 1, 'hill': exactly one of"},
    {FILE_OF(VIEW("hill", "\"alt\":1e400")), "view 1, 'hill': \"alt\" is inf"},
    {FILE_OF(VIEW("hill", "\"alt\":\"high\"")), "view 1, 'hill': \"alt\" is not a number"},
    {FILE_OF(VIEW("hill", "\"alt\":1,\"fov\":200")), "view 1, 'hill': \"fov\" is 200, not in"},
    {FILE_OF(VIEW("hill", "\"alt\":1,\"time\":2")), "\"time\" is not a member known here"},
    {FILE_OF("{\"name\":\"hill\",\"lat\":95,\"lon\":0,\"alt\":1,\"heading\":0,\"pitch\":0}"),
     "view 1, 'hill': \"lat\" is 95, not in -90..90"},
};

static void test_refused(void **state)
{
    (void)state;
    struct views_file file;
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        status s = load(refused[i].text, &file);
        if (!s || lines != 1 || !strstr(last, refused[i].words) || !strstr(last, file_name))
            fail_msg("%s: status %d, %d lines, '%s'", refused[i].text, (int)s, lines, last);
        assert_null(file.views);
    }
    assert_int_equal(views_file_load("nowhere.json", &file), ERR_NOT_FOUND);
}

static void test_accepted(void **state)
{
    (void)state;
    struct views_file file;
    assert_int_equal(
        load("{\"name\":\"Two\",\"fov\":90,\"views\":[" VIEW("a, b", "\"alt\":5e3") "," VIEW(
                 "c", "\"aboveGround\":2,\"roll\":3,\"fov\":5") "]}",
             &file),
        OK);
    assert_string_equal(file.name, "Two");
    assert_int_equal(file.count, 2);
    const named_view *a = &file.views[0], *c = &file.views[1];
    assert_string_equal(a->name, "a, b");
    check_near(a->camera.alt_m, 5000, 0);
    check_near(a->camera.fov_deg, 90, 0);
    assert_false(a->above_ground);
    assert_true(c->above_ground);
    check_near(c->camera.roll_deg, 3, 0);
    check_near(c->camera.fov_deg, 5, 0);
    views_file_deinit(&file);
}

static void test_shipped(void **state)
{
    (void)state;
    struct views_file file;
    assert_int_equal(views_file_load(VIEWS_FILE, &file), OK);
    assert_int_equal(file.count, 30);
    int telephoto = 0;
    for (int i = 0; i < file.count; i++) telephoto += file.views[i].camera.fov_deg == 5;
    assert_int_equal(telephoto, 4);
    views_file_deinit(&file);
}

static int set_up(void **state)
{
    (void)state;
    int made = mkstemp(file_name);
    if (made < 0) return -1;
    close(made);
    log_set_sink(count_lines, NULL);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    return unlink(file_name);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_accepted),
        cmocka_unit_test(test_shipped),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
