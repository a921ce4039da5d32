// The presets of public services: whole, credited, over https; and nothing is contacted before a
// tile of a source that was named is wanted. This program takes the place of the calls by which
// libraries reach the network, counts them and refuses.
#include "planet_fixture.h"
#include "check.h"

#include <errno.h>
#include <glob.h>
#include <netdb.h>
#include <stdatomic.h>
#include <sys/socket.h>

#include "base/clock.h"
#include "base/log.h"
#include "planet/source_set.h"
#include "planet/source_spec.h"

static atomic_int contacts;

// Exported, so that libcurl, GDAL and PROJ find them first.
__attribute__((visibility("default"))) int connect(int s, const struct sockaddr *to, socklen_t size)
{
    (void)s;
    (void)size;
    contacts += to->sa_family == AF_INET || to->sa_family == AF_INET6;
    errno = ECONNREFUSED;
    return -1;
}

__attribute__((visibility("default"))) int getaddrinfo(const char *node, const char *service,
                                                       const struct addrinfo *hints,
                                                       struct addrinfo **out)
{
    (void)node;
    (void)service;
    (void)hints;
    *out = NULL;
    contacts++;
    return EAI_FAIL;
}

static void quiet(void *user, enum log_level level, const char *line)
{
    (void)user;
    (void)level;
    (void)line;
}

static glob_t presets(void)
{
    glob_t found;
    assert_int_equal(glob(SOURCES_DIR "/*.json", 0, NULL, &found), 0);
    return found;
}

static void whole_and_credited(void **state)
{
    (void)state;
    static char text[1 << 16];
    glob_t found = presets();
    int heights = 0, colors = 0;
    for (size_t i = 0; i < found.gl_pathc; i++) {
        FILE *f = fopen(found.gl_pathv[i], "rb");
        size_t size = fread(text, 1, sizeof text, f);
        fclose(f);
        source_spec spec;
        assert_int_equal(source_spec_parse(text, size, found.gl_pathv[i], &spec), OK);
        if (strlen(spec.meta.attribution) < 10 || !spec.meta.name[0])
            fail_msg("%s: credits nobody", found.gl_pathv[i]);
        for (int k = 0; k < spec.count; k++) {
            if (strncmp(spec.layers[k].url, "https://", 8) != 0)
                fail_msg("%s: %s: not over https", found.gl_pathv[i], spec.layers[k].url);
            heights += spec.layers[k].layer == LAYER_HEIGHT;
            colors += spec.layers[k].layer == LAYER_COLOR;
        }
        source_spec_deinit(&spec);
    }
    globfree(&found);
    print_message("%d presets of heights, %d of colour\n", heights, colors);
    assert_true(heights >= 1 && colors >= 2);
}

// Wants a tile for a moment.
static void want_tile(struct pyramid *p, tile_id id)
{
    const pyramid_tile *tile;
    struct want *want = want_create(0);
    if (pyramid_try(p, id, want, &tile) == OK) pyramid_release(p, &tile);
    want_wait(want, 0.3);
    want_release(&want);
}

static void nothing_is_contacted_unless_named_and_wanted(void **state)
{
    (void)state;
    fixture f;
    fixture_init(&f, "presets");
    fixture_write(&f, 1, 0, fixture_smooth_height, NULL);
    pyramid_params tiles = {0};
    source_set_params none = {0};
    struct pyramid *p;
    struct source_set *set = source_set_create(&none);
    assert_int_equal(source_set_add(set, f.path, LAYER_COUNT, 1), OK);
    assert_int_equal(source_set_pyramid(set, &tiles, &p), OK);
    want_tile(p, (tile_id){LAYER_HEIGHT, 3, 2, 5});
    assert_null(source_set_fetcher(set));
    assert_int_equal(contacts, 0);
    pyramid_destroy(&p);
    source_set_destroy(&set);

    glob_t found = presets();
    for (size_t i = 0; i < found.gl_pathc; i++) {
        struct source_set *named = source_set_create(&none);
        assert_int_equal(source_set_add(named, found.gl_pathv[i], LAYER_COUNT, 1), OK);
        assert_int_equal(source_set_pyramid(named, &tiles, &p), OK);
        clock_sleep_s(0.1);
        assert_int_equal(contacts, 0);
        bool heights = pyramid_meta(p)->max_zoom[LAYER_HEIGHT] >= 0;
        want_tile(p, (tile_id){heights ? LAYER_HEIGHT : LAYER_COLOR, 2, 1, 1});
        assert_true(contacts > 0); // the count sees it
        pyramid_destroy(&p);
        source_set_destroy(&named);
        contacts = 0;
    }
    globfree(&found);
    fixture_deinit(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_and_credited),
        cmocka_unit_test(nothing_is_contacted_unless_named_and_wanted),
    };
    log_set_sink(quiet, NULL);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
