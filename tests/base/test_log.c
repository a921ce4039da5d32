#include "check.h"

#include <pthread.h>

#include "base/log.h"
#include "base/status.h"

struct heard {
    int count;
    enum log_level level;
    char line[2048];
};

static void listen(void *user, enum log_level level, const char *line)
{
    struct heard *h = user;
    h->count++;
    h->level = level;
    snprintf(h->line, sizeof h->line, "%s", line);
}

static struct heard heard;

static int start(void **state)
{
    (void)state;
    heard = (struct heard){0};
    log_set_sink(listen, &heard);
    log_set_level(LOG_INFO);
    return 0;
}

static int stop(void **state)
{
    (void)state;
    log_set_sink(NULL, NULL);
    return 0;
}

static void reaches_the_sink(void **state)
{
    (void)state;
    log_warn("%s holds %d", "a.planet", 42);
    assert_int_equal(heard.count, 1);
    assert_int_equal(heard.level, LOG_WARN);
    assert_string_equal(heard.line, "a.planet holds 42");
}

static void levels(void **state)
{
    (void)state;
    log_debug("no");
    assert_int_equal(heard.count, 0);
    log_info("yes");
    assert_int_equal(heard.count, 1);
    log_set_level(LOG_ERROR);
    log_warn("no");
    log_info("no");
    assert_int_equal(heard.count, 1);
    log_error("yes");
    assert_int_equal(heard.count, 2);
    log_set_level(LOG_DEBUG);
    log_debug("yes");
    assert_int_equal(heard.count, 3);
    assert_int_equal(heard.level, LOG_DEBUG);
}

static void *other_thread(void *arg)
{
    *(int *)arg = log_last_error()[0] == '\0';
    log_error("theirs");
    return NULL;
}

static void last_error_is_the_threads_own(void **state)
{
    (void)state;
    log_error("mine %d", 1);
    log_warn("not an error");
    pthread_t thread;
    int was_empty = 0;
    assert_int_equal(pthread_create(&thread, NULL, other_thread, &was_empty), 0);
    pthread_join(thread, NULL);
    assert_true(was_empty);
    assert_string_equal(log_last_error(), "mine 1");
}

static void long_lines_are_cut(void **state)
{
    (void)state;
    char text[3000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    log_error("%s", text);
    assert_int_equal(heard.count, 1);
    assert_true(strlen(heard.line) > 500 && strlen(heard.line) < sizeof text - 1);
    assert_string_equal(log_last_error(), heard.line);
}

static void every_status_has_a_text(void **state)
{
    (void)state;
    for (int i = OK; i <= ERR_UNSUPPORTED; i++) {
        assert_true(status_text((status)i)[0] != '\0');
        for (int j = OK; j < i; j++) {
            assert_string_not_equal(status_text((status)i), status_text((status)j));
        }
    }
    assert_string_equal(status_text((status)999), "unknown status");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(reaches_the_sink, start),
        cmocka_unit_test_setup(levels, start),
        cmocka_unit_test_setup(last_error_is_the_threads_own, start),
        cmocka_unit_test_setup(long_lines_are_cut, start),
        cmocka_unit_test(every_status_has_a_text),
    };
    return cmocka_run_group_tests(tests, NULL, stop);
}
