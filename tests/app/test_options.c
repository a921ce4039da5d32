// What the command line accepts and refuses: a table of command lines, each with the words its one
// message must hold.
#include "check.h"

#include "app/option_table.h"
#include "app/options.h"
#include "base/log.h"

enum { MAX_ARGS = 32 };

static int lines;
static char last[1024];

static void count_lines(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level != LOG_ERROR) return;
    lines++;
    snprintf(last, sizeof last, "%s", line);
}

// Splits at blanks into the static argv; "~" stands for an empty argument.
static status parse(const char *text, struct options *out)
{
    static char copy[1024];
    static char *argv[MAX_ARGS + 1];
    int argc = 0;
    snprintf(copy, sizeof copy, "%s", text);
    for (char *word = strtok(copy, " "); word && argc < MAX_ARGS; word = strtok(NULL, " "))
        argv[argc++] = strcmp(word, "~") == 0 ? word + 1 : word;
    argv[argc] = NULL;
    enum command command;
    assert_true(command_find(argv[0], &command));
    lines = 0;
    return options_parse(command, argc, argv, out);
}

static const char *const accepted[] = {
    "view",
    "view earth.planet",
    "view --camera 45.45,10.72,450,320,-3",
    "view --camera geo:45.45,10.72,450;heading=320;pitch=-3;fov=40",
    "view --size 800x600 -v",
    "render -o a.png",
    "render p --lat -90 --lon 360 --alt -12000 --heading -360 --pitch 90 --roll 180 --fov 179 -o a",
    "render --lat=+1e1 --lon=.5 --fov 0.01 --output=a.exr --half",
    "render --size 16384x1 -o a --samples 8 --timeout 0 --threads 256",
    "render --time noon -o a",
    "render --time 2026-06-21T10:00:30Z -o a --transform blend --filter hardware --texcoord vertex",
    "render --mode spherical --no-cull --no-synthesis --levels 6-21 --azimuth-steps 512 --rings 20 "
    "-o a",
    "render --mode reference -o a",
    "render --mode planar --planar-n 255 --planar-heights packed --planar-residuals --planar-form "
    "2004 "
    "--planar-triangles 50000 -o a",
    "render --mode reference --zoom auto --zoom-error 0.1 -o a",
    "render --mode reference --zoom stored --heights bicubic -o a",
    "compare --heights bilinear --samples 8",
    "fly --mode reference --zoom 24 --path f -o %d.png",
    "render --cache-bytes 1G --shader-dir x --stats s --no-wait --wait -o a",
    "render -o a -- --odd-name.planet",
    "fly --path f -o %d.png",
    "fly p --path f -o %05d.png --fps 0.5 --start 1 --end 1 --contact-sheet c.png --contact-grid "
    "6x4",
    "import --height a b --color c --night d -o e --body moon --bounds -10,-5,10,5 --resume",
    "import --height=a --height b -o e --name N --attribution A --force --threads 2",
    "import --height a -o e --bounds 170,-5,-170,5",
    "import --height a -o e --feather 500m",
    "import --height a -o e --feather auto",
    "import --height a -o e --feather 0",
    "import --earth",
    "import --earth --bathymetry --atlas x -o e",
    "compare",
    "compare p --a spherical --b reference --zoom 3 --csv c --json j --picture p.png -o d",
    "compare --a a.exr --b b.exr",
    "compare --path f --frames 3 --start 1 --end 2 --transform exact --rings 20 --size 10x10",
    "compare --camera 1,2,3 --fov 5 --no-synthesis --time noon",
    "compare --modes all --views v --equal error=0.5 --repeats 0 --b grid",
    "compare --modes grid,planar --path f --fps 60 --frames 3 --equal triangles",
    "info",
    "info p --json",
    "render --help",
    "fly --help",
};

static void test_accepted(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof accepted / sizeof accepted[0]; i++) {
        struct options o;
        status s = parse(accepted[i], &o);
        if (s) fail_msg("'%s' was refused: %s", accepted[i], last);
        options_deinit(&o);
    }
}

static const struct {
    const char *line, *words;
} refused[] = {
    {"view --lat 90.0001", "--lat 90.0001"},
    {"view --lat -91", "--lat -91"},
    {"view --lat 1x", "--lat 1x"},
    {"view --lat 0x10", "--lat 0x10"},
    {"view --lat nan", "--lat nan"},
    {"view --lat inf", "--lat inf"},
    {"view --lat 1e999", "--lat 1e999"},
    {"view --lat 1e", "--lat 1e"},
    {"view --lat .", "--lat ."},
    {"view --lat ~", "--lat "},
    {"view --lat 1,5", "--lat 1,5"},
    {"view --lon 361", "--lon 361"},
    {"view --alt -12001", "--alt -12001"},
    {"view --alt 1e11", "--alt 1e11"},
    {"view --fov 0", "--fov 0"},
    {"view --fov 180", "--fov 180"},
    {"view --pitch 91", "--pitch 91"},
    {"view --roll 181", "--roll 181"},
    {"view --above-ground -1", "--above-ground -1"},
    {"view --alt 5 --above-ground 5", "--above-ground"},
    {"view --camera 1,2", "1,2"},
    {"view --camera 1,2,3,4", "1,2,3,4"},
    {"view --camera 1,2,3,4,5,6,7,8", "1,2,3,4,5,6,7,8"},
    {"view --camera 91,2,3", "lat 91"},
    {"view --camera geo:1,2;tilt=3", "tilt=3"},
    {"view --camera geo:1,2;pitch=x", "pitch=x"},
    {"view --camera geo:1", "geo:1"},
    {"view a b", "'b'"},
    {"view --samples 2", "--samples"},
    {"view --nonsense", "--nonsense"},
    {"view -z", "-z"},
    {"view --no-cull=1", "--no-cull"},
    {"view --lat", "--lat"},
    {"render", "-o is missing"},
    {"render -o", "--output"},
    {"render -o ~", "--output"},
    {"render -o a --size 0x10", "--size 0x10"},
    {"render -o a --size 16385x1", "--size 16385x1"},
    {"render -o a --size 10", "--size 10"},
    {"render -o a --size 10x", "--size 10x"},
    {"render -o a --size 10x10x10", "--size 10x10x10"},
    {"render -o a --size -5x5", "--size -5x5"},
    {"render -o a --samples 0", "--samples 0"},
    {"render -o a --samples 9", "--samples 9"},
    {"render -o a --samples 1.5", "--samples 1.5"},
    {"render -o a --samples 99999999999999999999", "--samples 99999999999999999999"},
    {"render -o a --threads 0", "--threads 0"},
    {"render -o a --timeout -1", "--timeout -1"},
    {"render -o a --time 2026-13-01T00:00", "2026-13-01T00:00"},
    {"render -o a --time midnight", "--time midnight"},
    {"render -o a --transform fast", "--transform fast"},
    {"render -o a --filter none", "--filter none"},
    {"render -o a --texcoord both", "--texcoord both"},
    {"render -o a --mode hexagonal", "--mode hexagonal: not spherical, planar"},
    {"render -o a --mode planar --planar-n 30", "--planar-n 30"},
    {"render -o a --mode planar --planar-n 1024", "--planar-n 1024"},
    {"render -o a --mode planar --planar-n n", "--planar-n n"},
    {"render -o a --mode planar --planar-n 64", "--planar-n 64: not 31, 63"},
    {"render -o a --mode grid --grid 0x0", "--grid 0x0"},
    {"render -o a --mode grid --grid 4096x4096", "--grid 4096x4096: not ROWSxCOLUMNS with up to"},
    {"view --mode planar --planar-heights tall", "--planar-heights tall"},
    {"render -o a --mode planar --planar-form 2005", "--planar-form 2005"},
    {"render -o a --mode planar --planar-triangles 10", "--planar-triangles 10"},
    {"view --mode reference", "--mode reference"},
    {"fly --path f -o a --mode Reference", "--mode Reference"},
    {"render -o a --zoom 5", "--zoom: only with --mode reference"},
    {"render -o a --mode spherical --zoom auto", "--zoom: only with --mode reference"},
    {"render -o a --mode reference --zoom 25", "--zoom 25"},
    {"render -o a --mode reference --zoom -1", "--zoom -1"},
    {"render -o a --mode reference --zoom 3.5", "--zoom 3.5"},
    {"render -o a --mode reference --zoom finest", "--zoom finest"},
    {"render -o a --mode reference --zoom ~", "--zoom"},
    {"view --zoom 3", "--zoom"},
    {"render -o a --zoom-error 0.1", "--zoom-error 0.1: only with"},
    {"render -o a --mode reference --zoom 3 --zoom-error 0.1", "--zoom-error 0.1: only with"},
    {"render -o a --mode reference --zoom-error 0", "--zoom-error 0"},
    {"render -o a --mode reference --heights cubic", "--heights cubic"},
    {"render -o a --heights bicubic", "--heights: only with"},
    {"compare --a x.exr --b spherical --heights bicubic", "--heights: only with"},
    {"render -o a --mode reference --zoom-error nan", "--zoom-error nan"},
    {"render -o a --levels 9-6", "--levels 9-6"},
    {"render -o a --levels 6", "--levels 6"},
    {"render -o a --levels 0-24", "--levels 0-24"},
    {"render -o a --levels 0-0", "--levels 0-0"},
    {"render -o a --azimuth-steps 100", "--azimuth-steps 100"},
    {"render -o a --azimuth-steps 0", "--azimuth-steps 0"},
    {"render -o a --rings 0", "--rings 0"},
    {"render -o a --rings 21", "--rings 21"},
    {"render -o a --cache-bytes 0", "--cache-bytes 0"},
    {"render -o a --cache-bytes 5T", "--cache-bytes 5T"},
    {"render -o a --cache-bytes 2000G", "--cache-bytes 2000G"},
    {"render -o a --cache-bytes M", "--cache-bytes M"},
    {"fly -o %d.png", "--path is missing"},
    {"fly --path f", "-o is missing"},
    {"fly --path f -o a --fps 0", "--fps 0"},
    {"fly --path f -o a --start 5 --end 4", "--end 4"},
    {"fly --path f -o a --contact-grid 0x4", "--contact-grid 0x4"},
    {"fly --path f -o a --lat 4", "--lat"},
    {"import -o e", "--height"},
    {"import --height a", "-o is missing"},
    {"import a --height b -o e", "a: --height"},
    {"import --earth --height a", "--earth"},
    {"import --earth --codec exact", "--codec"},
    {"import --earth --quantum 1", "--quantum"},
    {"import --earth --bounds 5,44,17,49", "--bounds"},
    {"import --height a -o e --bathymetry", "--bathymetry"},
    {"import --height a -o e --body pluto", "--body pluto"},
    {"import --height a -o e --bounds 1,2,3", "--bounds 1,2,3"},
    {"import --height a -o e --feather 256", "--feather 256"},
    {"import --height a -o e --feather 1.5", "--feather 1.5"},
    {"import --height a -o e --feather -5m", "--feather -5m"},
    {"import --height a -o e --feather 2e6m", "--feather 2e6m"},
    {"import --height a -o e --feather m", "--feather m"},
    {"import --height a -o e --bounds 10,0,10,5", "--bounds 10,0,10,5"},
    {"import --height a -o e --bounds 10,5,20,0", "--bounds 10,5,20,0"},
    {"import --height a -o e --bounds -361,0,0,5", "--bounds -361"},
    {"import --height a -o e --bounds 0,0,0,0", "--bounds 0,0,0,0"},
    {"info --lat 3", "--lat"},
    {"info a b", "'b'"},
    {"fly --help --path", "--path"},
};

static void test_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        struct options o;
        status s = parse(refused[i].line, &o);
        if (s != ERR_ARGUMENT) fail_msg("'%s' gave status %d", refused[i].line, (int)s);
        if (lines != 1) fail_msg("'%s' gave %d messages", refused[i].line, lines);
        if (!strstr(last, refused[i].words))
            fail_msg("'%s': '%s' does not say '%s'", refused[i].line, last, refused[i].words);
    }
}

static void test_values(void **state)
{
    (void)state;
    struct options o;
    assert_int_equal(
        parse("render --lat -45.25 --camera 10,20,300 --pitch -7 --size 640x480 -o a.png "
              "--levels 6-23 --cache-bytes 3M --time 1970-01-02T00:00Z x.planet",
              &o),
        OK);
    check_near(o.camera.lat_deg, 10, 0); // the later of two wins
    check_near(o.camera.alt_m, 300, 0);
    check_near(o.camera.pitch_deg, -7, 0);
    assert_true(isnan(o.camera.heading_deg));
    assert_int_equal(o.width, 640);
    assert_int_equal(o.height, 480);
    assert_int_equal(o.view_params.first_level, 6);
    assert_int_equal(o.view_params.last_level, 23);
    assert_int_equal(o.planet_params.cache_bytes, 3 << 20);
    check_near(o.unix_time_s, 86400, 0);
    assert_true(o.time_given);
    assert_string_equal(o.planet, "x.planet");
    assert_true(options_camera_given(&o));
    options_deinit(&o);
    assert_int_equal(parse("view", &o), OK);
    assert_false(options_camera_given(&o));
    options_deinit(&o);
}

static void test_feather(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int rows;
        double metres;
    } cases[] = {{"import --height a -o e", FEATHER_ROWS, FEATHER_AUTO},
                 {"import --height a -o e --feather auto", FEATHER_ROWS, FEATHER_AUTO},
                 {"import --height a -o e --feather 500m", FEATHER_ROWS, 500},
                 {"import --height a -o e --feather 40", 40, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct options o;
        assert_int_equal(parse(cases[i].text, &o), OK);
        assert_int_equal(o.feather_rows, cases[i].rows);
        assert_true(o.feather_m == cases[i].metres);
        options_deinit(&o);
    }
}

static void test_import_order(void **state)
{
    (void)state;
    struct options o;
    assert_int_equal(parse("import --height a b --color=c --height d -o e --body mars", &o), OK);
    static const struct {
        enum tile_layer layer;
        const char *path;
    } want[] = {{LAYER_HEIGHT, "a"}, {LAYER_HEIGHT, "b"}, {LAYER_COLOR, "c"}, {LAYER_HEIGHT, "d"}};
    assert_int_equal(o.source_count, 4);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(o.sources[i].layer, want[i].layer);
        assert_string_equal(o.sources[i].path, want[i].path);
    }
    check_near(o.ellipsoid.b, 3376200, 0);
    assert_string_equal(o.body_name, "Mars");
    options_deinit(&o);
}

static void test_table(void **state)
{
    (void)state;
    for (int i = 0; i < option_count; i++) {
        const struct option_spec *a = &option_table[i];
        assert_true(a->commands != 0 && a->help[0] != '\0');
        bool flag = a->kind == OPTION_FLAG || a->kind == OPTION_UNFLAG;
        assert_true(flag == (a->value_name == NULL));
        for (int j = 0; j < i; j++) {
            const struct option_spec *b = &option_table[j];
            if (strcmp(a->name, b->name) == 0 && (a->commands & b->commands))
                fail_msg("--%s is twice in one command", a->name);
        }
    }
}

// Every option stands in the manual pages.
static void test_manual(void **state)
{
    (void)state;
    static char text[1 << 17];
    static const char *const pages[] = {MANUAL_PAGES ".1", MANUAL_PAGES "-compare.1",
                                        MANUAL_PAGES "-import.1"};
    size_t size = 0;
    for (int i = 0; i < 3; i++) {
        FILE *f = fopen(pages[i], "r");
        assert_non_null(f);
        size_t read = fread(text + size, 1, sizeof text - 1 - size, f);
        assert_true(read > 0);
        fclose(f);
        size += read;
    }
    assert_in_range(size, 1, sizeof text - 2);
    for (int i = 0; i < option_count; i++) {
        char alone[64], after_letter[64];
        snprintf(alone, sizeof alone, "Fl -%s", option_table[i].name);
        snprintf(after_letter, sizeof after_letter, " , -%s", option_table[i].name);
        if (!strstr(text, alone) && !strstr(text, after_letter))
            fail_msg("--%s is not in the manual pages", option_table[i].name);
    }
}

int main(void)
{
    log_set_sink(count_lines, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_accepted), cmocka_unit_test(test_refused),
        cmocka_unit_test(test_values),   cmocka_unit_test(test_import_order),
        cmocka_unit_test(test_feather),  cmocka_unit_test(test_table),
        cmocka_unit_test(test_manual),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
