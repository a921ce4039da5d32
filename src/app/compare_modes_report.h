// The tables of modes side by side: for people on standard output, CSV and JSON for programs. Main
// only.
#ifndef PERIGEE_APP_COMPARE_MODES_REPORT_H
#define PERIGEE_APP_COMPARE_MODES_REPORT_H

#include "app/compare_equal.h"
#include "app/compare_report.h"
#include "reference/flicker.h"

// Of all rows.
typedef struct compare_modes_head {
    const char *const *modes; // mode_count names
    int mode_count;
    const char *judge, *planet;
    int width, height;
    bool flight;
    double step_s; // of a flight: flicker is between two moments so far apart
    enum option_equal equal;
    int repeats; // frames timed
} compare_modes_head;

// One mode at one camera.
typedef struct compare_mode_row {
    const char *mode;
    char view[64]; // "" for the camera of the options
    compare_row row;
    compare_size size;
    double goal; // of --equal, NaN: none
    uint64_t triangles_total, triangles_drawn, draws;
    uint64_t bytes_filled; // uploaded to come here from the camera before
    double bytes_step;     // and to go on to the flight's next moment, NaN: no flight
    size_t gpu_bytes;
    double gpu_time;        // of the first mode's, NaN: not measured
    flicker_result flicker; // counts 0: no flight
} compare_mode_row;

// The rows of one camera, one a mode; before the first camera (first) the titles.
void compare_modes_report_lines(FILE *f, const compare_modes_head *head,
                                const compare_mode_row *rows, bool first);

// Each mode over all cameras.
void compare_modes_report_summary(FILE *f, const compare_modes_head *head,
                                  const compare_mode_row *rows, int count);

// By way of PATH.part; an empty field or null is a number that was not measured. ERR_IO,
// ERR_MEMORY, logged.
status compare_modes_report_csv(const char *path, const compare_mode_row *rows, int count);
status compare_modes_report_json(const char *path, const compare_modes_head *head,
                                 const compare_mode_row *rows, int count);

#endif
