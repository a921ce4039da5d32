// Strict decimal numbers: the whole text is one finite number, nothing before or after it. Any
// thread.
#ifndef PERIGEE_APP_NUMBER_H
#define PERIGEE_APP_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

// [+-] digits [. digits] [e [+-] digits]; no hexadecimal, no "inf", no "nan", no blanks. false
// leaves *out alone.
bool number_parse(const char *text, double *out);

// [+-] digits within the range of long long.
bool number_parse_integer(const char *text, long long *out);

// Splits `text` at `separator` into at most `max` numbers. Returns how many there are, or -1 when a
// part is not a number or there are more than `max`.
int number_parse_list(const char *text, char separator, double *out, int max);

#endif
