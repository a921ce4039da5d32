// Flights in JSON: what is accepted, and that each fault is one line naming the file, the key and
// the value. The shipped flights load, and end where their names say.
#include "check.h"

#include <unistd.h>

#include "app/path_file.h"
#include "base/log.h"

static int lines;
static char last[1024];
static char file_name[] = "test_path_file-XXXXXX";

static void count_lines(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level != LOG_ERROR) return;
    lines++;
    snprintf(last, sizeof last, "%s", line);
}

static status load(const char *text, size_t size, struct path_file *out)
{
    FILE *f = fopen(file_name, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(text, 1, size, f), size);
    fclose(f);
    lines = 0;
    return path_file_load(file_name, out);
}

#define KEY(rest)                                                                                  \
    "{\"keys\":[{\"time\":0,\"lat\":45,\"lon\":10,\"heading\":0,\"pitch\":-90," rest "}]}"

static const struct {
    const char *text, *words;
} refused[] = {
    {"", "line 1: not JSON"},
    {"{", "not JSON"},
    {"{\n\"keys\": [\n{]}", "line 3: not JSON"},
    {"[]", "not a JSON object"},
    {"{} x", "not JSON"},
    {"{}", "\"keys\""},
    {"{\"keys\":[]}", "\"keys\""},
    {"{\"keys\":3}", "\"keys\""},
    {"{\"keys\":[3]}", "key 1: not a JSON object"},
    {"{\"keys\":[{}]}", "key 1: \"time\" is missing"},
    {KEY("\"alt\":1e3,\"tilt\":1"), "key 1: \"tilt\""},
    {KEY("\"alt\":1e3,\"lat\":46"), "key 1: \"lat\" stands there twice"},
    {KEY("\"roll\":1"), "key 1: exactly one of \"alt\" and \"aboveGround\""},
    {KEY("\"alt\":1e3,\"aboveGround\":2"), "key 1: exactly one of \"alt\" and \"aboveGround\""},
    {KEY("\"alt\":\"high\""), "key 1: \"alt\" is not a number"},
    {KEY("\"alt\":1e999"), "key 1: \"alt\" is inf"},
    {KEY("\"alt\":-5"), "key 1: \"alt\" is -5"},
    {KEY("\"aboveGround\":0"), "key 1: \"aboveGround\" is 0"},
    {KEY("\"alt\":1e3,\"fov\":200"), "key 1: \"fov\" is 200"},
    {"{\"keys\":[{\"time\":0,\"lat\":91,\"lon\":10,\"alt\":1,\"heading\":0,\"pitch\":0}]}",
     "key 1: \"lat\" is 91"},
    {"{\"keys\":[{\"time\":1,\"lat\":9,\"lon\":10,\"alt\":1,\"heading\":0,\"pitch\":0},"
     "{\"time\":1,\"lat\":9,\"lon\":10,\"alt\":1,\"heading\":0,\"pitch\":0}]}",
     "key 2: \"time\" 1 does not come after 1"},
    {"{\"name\":3,\"keys\":[]}", "\"name\" is not a text"},
    {"{\"time\":\"noon\",\"keys\":[]}", "\"time\" is 'noon'"},
    {"{\"fov\":0,\"keys\":[]}", "\"fov\" is 0"},
    {"{\"speed\":0,\"keys\":[]}", "\"speed\""},
};

static void test_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        struct path_file p;
        status s = load(refused[i].text, strlen(refused[i].text), &p);
        if (s != ERR_FORMAT) fail_msg("'%s' gave status %d", refused[i].text, (int)s);
        if (lines != 1) fail_msg("'%s' gave %d messages", refused[i].text, lines);
        if (!strstr(last, file_name) || !strstr(last, refused[i].words))
            fail_msg("'%s': '%s' does not say '%s'", refused[i].text, last, refused[i].words);
    }
}

// Every prefix of a good file and every single byte set to 0 or 255: an answer, and a message
// exactly when refused.
static void test_damaged(void **state)
{
    (void)state;
    static const char good[] = KEY("\"alt\":1e3");
    char text[sizeof good];
    for (size_t i = 0; i < 2 * (sizeof good - 1); i++) {
        struct path_file p;
        memcpy(text, good, sizeof good);
        text[i / 2] = (char)(i % 2 ? 255 : 0);
        status s = load(text, sizeof good - 1, &p);
        assert_int_equal(lines, s != OK);
        path_file_deinit(&p);
        s = load(good, i / 2, &p);
        assert_int_equal(s, ERR_FORMAT);
        assert_int_equal(lines, 1);
    }
}

static void test_missing(void **state)
{
    (void)state;
    struct path_file p;
    lines = 0;
    assert_int_equal(path_file_load("no-such-flight.json", &p), ERR_NOT_FOUND);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(last, "no-such-flight.json"));
    lines = 0;
    assert_int_not_equal(path_file_load(".", &p), OK);
    assert_int_equal(lines, 1);
}

static void test_accepted(void **state)
{
    (void)state;
    static const char text[] =
        "\n{\"name\":\"N\",\"fov\":40,\"time\":\"1970-01-01T01:00Z\",\"keys\":["
        "{\"time\":2,\"lat\":1,\"lon\":2,\"alt\":3,\"heading\":4,\"pitch\":-5,\"roll\":6,\"fov\":7}"
        ","
        "{\"time\":2.5,\"lat\":1,\"lon\":2,\"aboveGround\":3,\"heading\":4,\"pitch\":-5}]}\n \n";
    struct path_file p;
    assert_int_equal(load(text, sizeof text - 1, &p), OK);
    assert_int_equal(p.count, 2);
    assert_string_equal(p.name, "N");
    assert_true(p.time_given);
    check_near(p.unix_time_s, 3600, 0);
    check_near(p.keys[0].camera.roll_deg, 6, 0);
    check_near(p.keys[0].camera.fov_deg, 7, 0);
    check_near(p.keys[1].camera.fov_deg, 40, 0);
    assert_false(p.keys[0].above_ground);
    assert_true(p.keys[1].above_ground);
    path_file_deinit(&p);
}

static void test_shipped(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        double lat, lon;
    } flights[] = {
        {FLIGHTS_DIR "/orbit-to-garda.json", 45.5, 10.7},
        {FLIGHTS_DIR "/pole-crossing.json", 88.3, 142},
        {FLIGHTS_DIR "/everest.json", 27.9, 86.9},
    };
    for (size_t i = 0; i < sizeof flights / sizeof flights[0]; i++) {
        struct path_file p;
        lines = 0;
        if (path_file_load(flights[i].path, &p)) fail_msg("%s", last);
        const perigee_camera *end = &p.keys[p.count - 1].camera;
        check_near(end->lat_deg, flights[i].lat, 0.2);
        check_near(end->lon_deg, flights[i].lon, 0.2);
        path_file_deinit(&p);
    }
}

int main(void)
{
    log_set_sink(count_lines, NULL);
    int f = mkstemp(file_name);
    if (f < 0) return 1;
    close(f);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refused), cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_missing), cmocka_unit_test(test_accepted),
        cmocka_unit_test(test_shipped),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(file_name);
    return failed;
}
