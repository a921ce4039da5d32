// Apparent place of the sun (VSOP87, libnova) turned by apparent sidereal time. Time is the C
// library's proleptic Gregorian count without leap seconds.
#include "geo/sun.h"

#include <ctype.h>
#include <pthread.h>
#include <string.h>

#include <libnova/dynamical_time.h>
#include <libnova/sidereal_time.h>
#include <libnova/solar.h>

#define UNIX_EPOCH_JD 2440587.5
#define DAY_S         86400.0
#define DEGREE        (M_PI / 180)

// libnova keeps its last nutation and earth position in unguarded static variables.
static pthread_mutex_t libnova_lock = PTHREAD_MUTEX_INITIALIZER;

dvec3 geo_sun_direction(double unix_time_s)
{
    double jd = UNIX_EPOCH_JD + unix_time_s / DAY_S;
    struct ln_equ_posn sun;
    pthread_mutex_lock(&libnova_lock);
    ln_get_solar_equ_coords(ln_get_jde(jd), &sun);
    double sidereal_hours = ln_get_apparent_sidereal_time(jd);
    pthread_mutex_unlock(&libnova_lock);
    double lon = (sun.ra - 15 * sidereal_hours) * DEGREE, dec = sun.dec * DEGREE;
    return (dvec3){cos(dec) * cos(lon), cos(dec) * sin(lon), sin(dec)};
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
