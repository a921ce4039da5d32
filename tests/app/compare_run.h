// Runs the program in a folder of its own that holds a small planet (hills.planet) and a flight of
// two seconds over it (path.json), and reads what it wrote. Main thread only.
#ifndef PERIGEE_TESTS_APP_COMPARE_RUN_H
#define PERIGEE_TESTS_APP_COMPARE_RUN_H

#include "check.h"

enum { TEXT_SIZE = 1 << 16 };

// Standard output and error of the last run.
extern char out[TEXT_SIZE], err[TEXT_SIZE];

// Fixtures of the group: makes the folder and enters it; leaves and removes it.
int run_begin(void **state);
int run_end(void **state);

void read_text(const char *path, char text[TEXT_SIZE]); // "" when it cannot be read
void write_text(const char *path, const char *text);
int count_lines(const char *text);

// The program's exit status; -1 when it did not exit.
int run(const char *line);
void expect_good(const char *line);
// Exit status 1, nothing on standard output, one line with these words on standard error.
void expect_fault(const char *line, const char *words);

// What stands in a column of a row (0: the first below the titles) of a CSV file, without quotes.
const char *csv_text(const char *path, int row, const char *title);
// The same as a number; NaN when empty.
double csv_number(const char *path, int row, const char *title);

#endif
