// Reading a JSON file whole and its members with checks: every fault is one line "FILE: where:
// what". Main only.
#ifndef PERIGEE_APP_JSON_FILE_H
#define PERIGEE_APP_JSON_FILE_H

#include <stdbool.h>

#include "base/status.h"

struct cJSON; // a value of the cJSON library

// The file's one JSON object. ERR_NOT_FOUND, ERR_IO, ERR_FORMAT (also when it is larger than 16
// MiB). Free with cJSON_Delete.
status json_file_load(const char *path, struct cJSON **out);

// Where a value stands, for messages: "FILE" and "key 3" ("" at the top).
struct json_place {
    const char *path, *where;
};

// ERR_FORMAT, logged, when the value is none.
status json_check_object(struct json_place place, const struct cJSON *value);

// Every member's name must be one of names[0..count), and none may stand there twice.
status json_check_members(struct json_place place, const struct cJSON *object,
                          const char *const *names, int count);

// A finite number in [low, high]. Absent: ERR_FORMAT when required, else *out is left alone.
status json_number(struct json_place place, const struct cJSON *object, const char *name,
                   double low, double high, bool required, double *out);

// A text; NULL when absent. Borrowed from the object.
status json_text(struct json_place place, const struct cJSON *object, const char *name,
                 const char **out);

#endif
