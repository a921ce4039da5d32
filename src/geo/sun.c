// Apparent place of the sun turned by apparent sidereal time. libnova gives the geometric place in
// the ecliptic of J2000 (VSOP87), nutation and sidereal time. Its ln_get_solar_equ_coords leaves
// out the precession, a third of a degree in 2023, and its ln_get_ecl_prec is wrong by tens of
// degrees, so the precession is our own.
#include "geo/sun.h"

#include <ctype.h>
#include <pthread.h>

#include <libnova/dynamical_time.h>
#include <libnova/nutation.h>
#include <libnova/sidereal_time.h>
#include <libnova/solar.h>

#define UNIX_EPOCH_JD 2440587.5
#define DAY_S         86400.0
#define DEGREE        (M_PI / 180)
#define ARCSECOND     (DEGREE / 3600)

// Constant of aberration, rad at 1 AU (Meeus, eq. 25.10).
#define ABERRATION (20.4898 * ARCSECOND)

// libnova keeps its last nutation and earth position in unguarded static variables.
static pthread_mutex_t libnova_lock = PTHREAD_MUTEX_INITIALIZER;

// Coordinates in a frame turned by an angle about x, about z.
static dvec3 turn_x(dvec3 v, double angle)
{
    double c = cos(angle), s = sin(angle);
    return (dvec3){v.x, c * v.y + s * v.z, c * v.z - s * v.y};
}

static dvec3 turn_z(dvec3 v, double angle)
{
    double c = cos(angle), s = sin(angle);
    return (dvec3){c * v.x + s * v.y, c * v.y - s * v.x, v.z};
}

// Mean ecliptic of J2000 to that of date.
//   source  IAU 1976 as in Meeus, Astronomical Algorithms, 2nd ed., eq. 21.5 with J2000 as the
//   start
static dvec3 precess(dvec3 v, double jde)
{
    double t = (jde - 2451545.0) / 36525;
    double tilt = ((0.000060 * t - 0.03302) * t + 47.0029) * t * ARCSECOND;
    double node = 174.876384 * DEGREE + (0.03536 * t - 869.8089) * t * ARCSECOND;
    double along = ((-0.000006 * t + 1.11113) * t + 5029.0966) * t * ARCSECOND;
    return turn_z(turn_x(turn_z(v, node), tilt), -(node + along));
}

dvec3 geo_sun_direction(double unix_time_s)
{
    double jd = UNIX_EPOCH_JD + unix_time_s / DAY_S, jde = ln_get_jde(jd);
    struct ln_helio_posn geometric;
    struct ln_nutation nutation;
    pthread_mutex_lock(&libnova_lock);
    ln_get_solar_geom_coords(jde, &geometric);
    ln_get_nutation(jde, &nutation);
    double sidereal_hours = ln_get_apparent_sidereal_time(jd);
    pthread_mutex_unlock(&libnova_lock);
    double lon = geometric.L * DEGREE, lat = geometric.B * DEGREE;
    dvec3 ecliptic = precess((dvec3){cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)}, jde);
    double shift = nutation.longitude * DEGREE - ABERRATION / geometric.R;
    double obliquity = (nutation.ecliptic + nutation.obliquity) * DEGREE;
    return turn_z(turn_x(turn_z(ecliptic, -shift), -obliquity), sidereal_hours * 15 * DEGREE);
}

// Exactly `digits` decimal digits at *at, which moves past them; -1 otherwise.
static int take_number(const char **at, int digits)
{
    int value = 0;
    for (int i = 0; i < digits; i++, (*at)++) {
        if (!isdigit((unsigned char)**at)) return -1;
        value = 10 * value + (**at - '0');
    }
    return value;
}

static int take_char(const char **at, char c)
{
    if (**at != c) return 0;
    (*at)++;
    return 1;
}

static int days_in_month(int year, int month)
{
    static const int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    int leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    return days[month - 1] + (month == 2 && leap);
}

// Days from 1970-01-01 in the proleptic Gregorian calendar, year >= 0. The year is counted from
// March.
static long days_from_civil(int year, int month, int day)
{
    long y = month > 2 ? year : year - 1L;
    long m = (month + 9) % 12;
    long leaps = (y >= 0 ? y / 4 - y / 100 + y / 400 : -1);
    return 365 * y + leaps + (153 * m + 2) / 5 + day - 719469;
}

int geo_time_parse(const char *text, double *unix_time_s)
{
    const char *at = text;
    int year = take_number(&at, 4);
    if (year < 0 || !take_char(&at, '-')) return -1;
    int month = take_number(&at, 2);
    if (month < 1 || month > 12 || !take_char(&at, '-')) return -1;
    int day = take_number(&at, 2);
    if (day < 1 || day > days_in_month(year, month) || !take_char(&at, 'T')) return -1;
    int hour = take_number(&at, 2);
    if (hour < 0 || hour > 23 || !take_char(&at, ':')) return -1;
    int minute = take_number(&at, 2);
    if (minute < 0 || minute > 59) return -1;
    int second = take_char(&at, ':') ? take_number(&at, 2) : 0;
    if (second < 0 || second > 59) return -1;
    take_char(&at, 'Z');
    if (*at) return -1;
    *unix_time_s =
        DAY_S * (double)days_from_civil(year, month, day) + 3600.0 * hour + 60.0 * minute + second;
    return 0;
}
