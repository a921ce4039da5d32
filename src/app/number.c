// The shape is checked here, character by character; strtod only converts what has passed.
#include "app/number.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBER_LENGTH = 64 };

static const char *skip_digits(const char *p)
{
    while (isdigit((unsigned char)*p)) p++;
    return p;
}

static bool decimal_shape(const char *p)
{
    if (*p == '+' || *p == '-') p++;
    const char *whole = p;
    p = skip_digits(p);
    ptrdiff_t digits = p - whole;
    if (*p == '.') {
        const char *fraction = ++p;
        p = skip_digits(p);
        digits += p - fraction;
    }
    if (digits == 0) return false;
    if (*p == 'e' || *p == 'E') {
        p++;
        if (*p == '+' || *p == '-') p++;
        const char *exponent = p;
        p = skip_digits(p);
        if (p == exponent) return false;
    }
    return *p == '\0';
}

bool number_parse(const char *text, double *out)
{
    if (!decimal_shape(text)) return false;
    double value = strtod(text, NULL);
    if (!isfinite(value)) return false;
    *out = value;
    return true;
}

bool number_parse_integer(const char *text, long long *out)
{
    const char *p = text;
    if (*p == '+' || *p == '-') p++;
    if (*p == '\0' || *skip_digits(p) != '\0') return false;
    errno = 0;
    long long value = strtoll(text, NULL, 10);
    if (errno == ERANGE) return false;
    *out = value;
    return true;
}

int number_parse_list(const char *text, char separator, double *out, int max)
{
    for (int count = 0; count < max; count++) {
        const char *end = strchr(text, separator);
        size_t length = end ? (size_t)(end - text) : strlen(text);
        char part[NUMBER_LENGTH];
        if (length >= sizeof part) return -1;
        memcpy(part, text, length);
        part[length] = '\0';
        if (!number_parse(part, &out[count])) return -1;
        if (!end) return count + 1;
        text = end + 1;
    }
    return -1;
}
