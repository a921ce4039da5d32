// The tables of a comparison: for people on standard output, CSV and JSON for programs. Main only.
#ifndef PERIGEE_APP_COMPARE_REPORT_H
#define PERIGEE_APP_COMPARE_REPORT_H

#include <stdio.h>

#include "app/options.h"
#include "reference/compare.h"

// Of all frames.
typedef struct compare_head {
    const char *a, *b, *planet; // as given; planet "" when no side needed one
    int width, height;
    bool flight;
    bool bicubic;           // the reference's heights between samples; false: bilinear
    const char *color_note; // what the colours of the sides hold
} compare_head;

typedef struct compare_row {
    int frame;
    double time_s;              // of the flight
    perigee_camera camera;      // its place geographic, as all places of `result`
    double easting, northing;   // the camera's on the map of a projected raster; else NaN
    double zoom_low, zoom_high; // of the heights of side b, NaN when it does not say
    compare_result result;
} compare_row;

// The whole table of one frame.
void compare_report_print(FILE *f, const compare_head *head, const compare_row *row);

// One line a frame; the first call of a flight (frame 0) prints the titles.
void compare_report_line(FILE *f, const compare_row *row);

// Lines with the text of the table, for a picture; what fits of count. Returns how many.
enum { COMPARE_LINE_SIZE = 160, COMPARE_LINES = 11 };
int compare_report_lines(const compare_row *row, char lines[COMPARE_LINES][COMPARE_LINE_SIZE]);

// A row a frame; an empty field is a number that was not measured. By way of PATH.part. ERR_IO,
// logged.
status compare_report_csv(const char *path, const compare_row *rows, int count);

// The same as one object: a number not measured is null, and so is the PSNR of equal pictures.
status compare_report_json(const char *path, const compare_head *head, const compare_row *rows,
                           int count);

// For tables with columns of their own before these: the titles, from ",time_s" on, a row's values,
// and its members added to an object.
struct cJSON;
void compare_report_csv_titles(FILE *f);
void compare_report_csv_values(FILE *f, const compare_row *row);
void compare_report_csv_number(FILE *f, double value); // a comma and the number, if it is one
void compare_report_json_members(struct cJSON *object, const compare_row *row);
void compare_report_json_number(struct cJSON *object, const char *name, double value);
void compare_report_json_stat(struct cJSON *object, const char *name, const compare_stat *stat);

// Opens PATH.part; and closes it and puts it in its place, or removes it. ERR_IO, logged.
status compare_report_begin(const char *path, FILE **out);
status compare_report_finish(FILE *f, const char *path);
// Writes the value to the file in this way.
status compare_report_json_write(const char *path, const struct cJSON *root);

#endif
