#include "check.h"

#include "geo/sun.h"

#define DEG (M_PI / 180)

// Times of the seasons: US Naval Observatory, "Earth's Seasons and Apsides", to the minute:
// declination moves 0.0003 degrees in it. Obliquity of date: IAU 1980 with nutation, 23.436
// to 23.439 in these years. Meeus: Astronomical Algorithms, 2nd ed., example 25.b (1992-10-13 0h TD
// = 23:59:01 UT): declination -7.783817; example 28.a: equation of time 3.427351 degrees, hence the
// subsolar longitude at 0h UT.
static const struct golden {
    const char *utc;
    double declination_deg, lon_deg; // NAN: not given
    double tol_deg;
} golden[] = {
    {"2000-03-20T07:35", 0, NAN, 0.001},
    {"2024-03-20T03:06", 0, NAN, 0.001},
    {"2024-09-22T12:44", 0, NAN, 0.001},
    {"2024-06-20T20:51", 23.4375, NAN, 0.002},
    {"2024-12-21T09:20", -23.4375, NAN, 0.002},
    {"1992-10-12T23:59:01", -7.783817, NAN, 0.0002},
    {"1992-10-13T00:00", NAN, 180 - 3.427351, 0.001},
};

static void published(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof golden / sizeof *golden; i++) {
        const struct golden *g = &golden[i];
        double time;
        assert_int_equal(geo_time_parse(g->utc, &time), 0);
        dvec3 d = geo_sun_direction(time);
        check_near(dvec3_length(d), 1, 1e-15);
        if (!isnan(g->declination_deg)) check_near(asin(d.z) / DEG, g->declination_deg, g->tol_deg);
        if (!isnan(g->lon_deg)) check_near(atan2(d.y, d.x) / DEG, g->lon_deg, g->tol_deg);
    }
}

// The sun goes west, a turn a day; the equation of time stays within its known bounds of -14.3 and
// +16.5 minutes.
static void goes_round(void **state)
{
    (void)state;
    double start;
    assert_int_equal(geo_time_parse("2023-01-01T12:00Z", &start), 0);
    double least = 1e9, most = -1e9;
    for (int day = 0; day < 365; day++) {
        dvec3 noon = geo_sun_direction(start + 86400.0 * day);
        double minutes = -atan2(noon.y, noon.x) / DEG * 4;
        least = fmin(least, minutes);
        most = fmax(most, minutes);
    }
    check_near(least, -14.25, 0.1);
    check_near(most, 16.45, 0.1);
    dvec3 a = geo_sun_direction(start), b = geo_sun_direction(start + 3600);
    check_near((atan2(a.y, a.x) - atan2(b.y, b.x)) / DEG, 15, 0.01);
}

static const struct {
    const char *text;
    double seconds;
} accepted[] = {
    {"1970-01-01T00:00", 0},
    {"1970-01-01T00:00:01Z", 1},
    {"2024-02-29T12:00Z", 1709208000},
    {"2000-01-01T12:00:00", 946728000},
    {"1969-12-31T23:59:59Z", -1},
    {"2038-01-19T03:14:08Z", 2147483648.0},
    {"1900-03-01T00:00", -2203891200.0},
    {"0000-03-01T00:00", -62162035200.0},
    {"0000-01-01T00:00", -62167219200.0},
};

static const char *const rejected[] = {
    "",
    "2024",
    "2024-01-01",
    "2024-01-01T",
    "2024-01-01T12",
    "2024-01-01T12:0",
    "2024-01-01 12:00",
    "2024-1-01T12:00",
    "2024-13-01T12:00",
    "2024-00-01T12:00",
    "2024-02-30T12:00",
    "2023-02-29T12:00",
    "1900-02-29T12:00",
    "2024-04-31T12:00",
    "2024-01-00T12:00",
    "2024-01-01T24:00",
    "2024-01-01T12:60",
    "2024-01-01T12:00:60",
    "2024-01-01T12:00:5",
    "2024-01-01T12:00:",
    "2024-01-01T12:00z",
    "2024-01-01T12:00ZZ",
    "2024-01-01T12:00:00.5Z",
    "2024-01-01T12:00+01:00",
    " 2024-01-01T12:00",
    "2024-01-01T12:00 ",
    "-2024-01-01T12:00",
    "+024-01-01T12:00",
    "20245-01-01T12:00",
    "noon",
};

static void time_parse(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof accepted / sizeof *accepted; i++) {
        double got = NAN;
        assert_int_equal(geo_time_parse(accepted[i].text, &got), 0);
        check_near(got, accepted[i].seconds, 0);
    }
    for (size_t i = 0; i < sizeof rejected / sizeof *rejected; i++) {
        double got = 42;
        if (geo_time_parse(rejected[i], &got) != -1) fail_msg("accepted: %s", rejected[i]);
        check_near(got, 42, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(published),
        cmocka_unit_test(goes_round),
        cmocka_unit_test(time_parse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
