// TileJSON and what may be wrong with it.
#include "planet/source_spec.h"

#include "base/log.h"
#include "check.h"

static char last[1024];

static void keep_line(void *user, enum log_level level, const char *line)
{
    (void)user;
    (void)level;
    snprintf(last, sizeof last, "%s", line);
}

static status parse(const char *text, const char *origin, source_spec *spec)
{
    last[0] = '\0';
    return source_spec_parse(text, strlen(text), origin, spec);
}

static void urls(void **state)
{
    (void)state;
    static const struct {
        const char *origin, *tiles, *more, *want; // of level 5, x 3, y 7 from the north
    } cases[] = {
        {"p.json", "https://a/{z}/{x}/{y}.png", "", "https://a/5/3/7.png"},
        {"p.json", "https://a/{z}/{x}/{-y}.png", "", "https://a/5/3/24.png"},
        {"p.json", "https://a/{z}/{x}/{y}.png", ",\"scheme\":\"tms\"", "https://a/5/3/24.png"},
        {"p.json", "http://a/w/{TileMatrix}/{TileRow}/{TileCol}.jpg", "", "http://a/w/5/7/3.jpg"},
        {"http://h:8/d/p.json", "t/{z}/{x}/{y}", "", "http://h:8/d/t/5/3/7"},
        {"http://h:8/d/p.json", "/t/{z}/{x}/{y}", "", "http://h:8/t/5/3/7"},
        {"http://h:8/d/p.json", "https://x/{z}/{x}/{y}?a={z}", "", "https://x/5/3/7?a=5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512], url[SPEC_URL_SIZE];
        source_spec spec;
        snprintf(text, sizeof text, "{\"tiles\":[\"%s\"]%s}", cases[i].tiles, cases[i].more);
        assert_int_equal(parse(text, cases[i].origin, &spec), OK);
        source_spec_url(&spec.layers[0], 5, 3, 7, url);
        assert_string_equal(url, cases[i].want);
        source_spec_deinit(&spec);
    }
}

static void members(void **state)
{
    (void)state;
    source_spec spec;
    assert_int_equal(
        parse("{\"name\":\"N\",\"attribution\":\"(c) A\",\"tiles\":[\"http://a/{z}/{x}/{y}\"],"
              "\"minzoom\":2,\"maxzoom\":14,\"bounds\":[5,44,17,49],\"encoding\":\"terrarium\","
              "\"tileSize\":512,\"unknown\":[1],\"perigee\":{\"projection\":\"geographic\","
              "\"available\":[[3,1,4,9],[2,0,0,3]],\"heightRange\":[-5,4000]}}",
              "x", &spec),
        OK);
    const spec_layer *l = &spec.layers[0];
    assert_string_equal(spec.meta.name, "N");
    assert_string_equal(spec.meta.attribution, "(c) A");
    assert_int_equal(l->layer, LAYER_HEIGHT);
    assert_int_equal(l->encoding, ENCODING_TERRARIUM);
    assert_int_equal(l->matrix.projection, MATRIX_GEOGRAPHIC);
    assert_true(l->matrix.tile_size == 512 && l->matrix.min_level == 2 &&
                l->matrix.max_level == 14);
    check_near(l->north, 49 * M_PI / 180, 1e-12);
    assert_int_equal(l->range_count, 2);
    assert_int_equal(l->ranges[0].zoom, 2);
    check_near(spec.meta.height_max, 4000, 0);
    assert_int_equal(spec.meta.max_zoom[LAYER_HEIGHT], 15); // 512 samples: one zoom more
    assert_int_equal(spec.meta.max_zoom[LAYER_COLOR], -1);
    source_spec_deinit(&spec);
}

#define T "\"tiles\":[\"http://a/{z}/{x}/{y}\"]"

// One line each, which names the document and what is wrong.
static void faults(void **state)
{
    (void)state;
    static const struct {
        const char *text, *said;
    } cases[] = {
        {"", "not a JSON object"},
        {"[]", "not a JSON object"},
        {"{}", "\"tiles\""},
        {"{\"tiles\":[]}", "\"tiles\""},
        {"{\"tiles\":[7]}", "\"tiles\""},
        {"{\"tiles\":[\"ftp://a/{z}/{x}/{y}\"]}", "\"tiles\""},
        {"{\"tiles\":[\"file:///etc/{z}/{x}/{y}\"]}", "\"tiles\""},
        {"{\"tiles\":[\"http://a/{z}/{x}\"]}", "lacks"},
        {"{\"tiles\":[\"http://a/{z}/{x}/{y}/{s}\"]}", "braces"},
        {"{\"tiles\":[\"http://a/{z}/{x}/{y\"]}", "braces"},
        {"{" T ",\"scheme\":\"zyx\"}", "\"scheme\""},
        {"{" T ",\"minzoom\":-1}", "\"minzoom\""},
        {"{" T ",\"maxzoom\":99}", "\"maxzoom\""},
        {"{" T ",\"maxzoom\":3,\"minzoom\":4}", "\"maxzoom\""},
        {"{" T ",\"maxzoom\":3.5}", "\"maxzoom\""},
        {"{" T ",\"tileSize\":300}", "\"tileSize\""},
        {"{" T ",\"tileSize\":1e9}", "\"tileSize\""},
        {"{" T ",\"bounds\":[0,0,1]}", "\"bounds\""},
        {"{" T ",\"bounds\":[0,50,1,40]}", "\"bounds\""},
        {"{" T ",\"encoding\":\"exr\"}", "\"encoding\""},
        {"{" T ",\"perigee\":{\"layer\":\"height\"}}", "\"encoding\""},
        {"{" T ",\"perigee\":{\"layer\":\"depth\"}}", "\"layer\""},
        {"{" T ",\"perigee\":{\"projection\":\"lambert\"}}", "\"projection\""},
        {"{" T ",\"tileSize\":512,\"perigee\":{\"projection\":\"planet\"}}", "\"projection\""},
        {"{" T ",\"perigee\":{\"ellipsoid\":[1,2]}}", "\"ellipsoid\""},
        {"{" T ",\"perigee\":{\"available\":[[1,2,3]]}}", "\"available\""},
        {"{\"layers\":[]}", "\"layers\""},
        {"{\"layers\":[7]}", "\"layers\""},
        {"{\"layers\":[{" T "},{" T "}]}", "twice"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        source_spec spec;
        assert_int_equal(parse(cases[i].text, "doc.json", &spec), ERR_FORMAT);
        if (!strstr(last, cases[i].said) || !strstr(last, "doc.json"))
            fail_msg("%s: said \"%s\"", cases[i].text, last);
    }
}

static void any_cut_of_a_document_is_survived(void **state)
{
    (void)state;
    const char *text = "{\"name\":\"\u00fc\u00fc\"," T ",\"bounds\":[5,44,17,49],\"perigee\":"
                       "{\"available\":[[3,1,4,9]],\"ellipsoid\":[6378137,6356752]}}";
    for (size_t n = 0; n <= strlen(text); n++) {
        source_spec spec;
        if (source_spec_parse(text, n, "cut", &spec) == OK) source_spec_deinit(&spec);
    }
}

int main(void)
{
    log_set_sink(keep_line, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(urls),
        cmocka_unit_test(members),
        cmocka_unit_test(faults),
        cmocka_unit_test(any_cut_of_a_document_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
