// The table of all options: one row each, with the commands that take it and the line that --help
// shows.
#ifndef PERIGEE_APP_OPTION_TABLE_H
#define PERIGEE_APP_OPTION_TABLE_H

#include "app/options.h"

enum option_group {
    GROUP_IMPORT,
    GROUP_COMPARE,
    GROUP_CAMERA,
    GROUP_FLIGHT,
    GROUP_PICTURE,
    GROUP_OUTPUT,
    GROUP_DATA,
    GROUP_METHOD,
    GROUP_GENERAL,
    GROUP_COUNT
};

enum option_kind {
    OPTION_FLAG,     // bool at offset becomes true
    OPTION_UNFLAG,   // bool at offset becomes false
    OPTION_TEXT,     // const char * at offset, not empty
    OPTION_NUMBER,   // double at offset, in [low, high]
    OPTION_INTEGER,  // int at offset, in [low, high]
    OPTION_VALUE,    // apply() reads the value
    OPTION_OPTIONAL, // apply() reads the value, NULL when none was given
};

struct option_spec {
    const char *name;
    char letter;       // 0: none
    unsigned commands; // bit (1 << command) for each command that takes it
    enum option_group group;
    enum option_kind kind;
    size_t offset;
    double low, high;
    // ERR_ARGUMENT, logged with `name` and `value`.
    status (*apply)(struct options *o, const char *name, const char *value);
    const char *value_name; // of the value in --help; NULL for flags
    const char *help;
};

extern const struct option_spec option_table[];
extern const int option_count;

#endif
