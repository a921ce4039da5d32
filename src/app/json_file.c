#include "app/json_file.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"

enum { FILE_MAX_BYTES = 16 << 20 };

static status read_stream(const char *path, FILE *f, char **text, size_t *size)
{
    size_t capacity = 1 << 16, length = 0, got;
    char *data = malloc(capacity);
    while (data && (got = fread(data + length, 1, capacity - length, f)) > 0) {
        length += got;
        if (length < capacity) continue;
        if (capacity > FILE_MAX_BYTES) break;
        char *larger = realloc(data, capacity *= 2);
        if (!larger) free(data);
        data = larger;
    }
    status s = OK;
    if (!data) {
        log_error("%s: out of memory", path);
        s = ERR_MEMORY;
    } else if (ferror(f)) {
        log_error("%s: cannot read: %s", path, strerror(errno));
        s = ERR_IO;
    } else if (length > FILE_MAX_BYTES) {
        log_error("%s: larger than %d bytes", path, FILE_MAX_BYTES);
        s = ERR_FORMAT;
    }
    if (s) free(data);
    *text = s ? NULL : data;
    *size = length;
    return s;
}

static status read_file(const char *path, char **text, size_t *size)
{
    *text = NULL;
    FILE *f = fopen(path, "rb");
    if (!f) {
        log_error("%s: cannot open: %s", path, strerror(errno));
        return errno == ENOENT ? ERR_NOT_FOUND : ERR_IO;
    }
    status s = read_stream(path, f, text, size);
    fclose(f);
    return s;
}

static int line_of(const char *text, const char *position)
{
    int line = 1;
    for (const char *p = text; p < position; p++) line += *p == '\n';
    return line;
}

status json_file_load(const char *path, cJSON **out)
{
    *out = NULL;
    char *text;
    size_t size;
    status s = read_file(path, &text, &size);
    if (s) return s;
    const char *end = text;
    cJSON *root = cJSON_ParseWithLengthOpts(text, size, &end, false);
    if (root) {
        const char *stop = text + size;
        while (end < stop && strchr(" \t\r\n", *end) && *end) end++;
        if (end < stop) {
            cJSON_Delete(root);
            root = NULL;
        }
    }
    if (!root) {
        log_error("%s: line %d: not JSON", path, line_of(text, end));
        s = ERR_FORMAT;
    } else if (!cJSON_IsObject(root)) {
        log_error("%s: not a JSON object", path);
        s = ERR_FORMAT;
    }
    if (s) cJSON_Delete(root);
    else *out = root;
    free(text);
    return s;
}

// "FILE: key 3" or "FILE".
static const char *place_text(struct json_place place, char *text, size_t size)
{
    snprintf(text, size, "%s%s%s", place.path, place.where[0] ? ": " : "", place.where);
    return text;
}

static status fault(struct json_place place, const char *what, const char *name)
{
    char at[512];
    log_error("%s: \"%.64s\" %s", place_text(place, at, sizeof at), name, what);
    return ERR_FORMAT;
}

static bool is_one_of(const char *name, const char *const *names, int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(name, names[i]) == 0) return true;
    return false;
}

status json_check_object(struct json_place place, const cJSON *value)
{
    char at[512];
    if (cJSON_IsObject(value)) return OK;
    log_error("%s: not a JSON object", place_text(place, at, sizeof at));
    return ERR_FORMAT;
}

status json_check_members(struct json_place place, const cJSON *object, const char *const *names,
                          int count)
{
    const cJSON *member;
    cJSON_ArrayForEach(member, object)
    {
        if (!is_one_of(member->string, names, count))
            return fault(place, "is not a member known here", member->string);
        if (cJSON_GetObjectItemCaseSensitive(object, member->string) != member)
            return fault(place, "stands there twice", member->string);
    }
    return OK;
}

status json_number(struct json_place place, const cJSON *object, const char *name, double low,
                   double high, bool required, double *out)
{
    const cJSON *member = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!member) return required ? fault(place, "is missing", name) : OK;
    if (!cJSON_IsNumber(member)) return fault(place, "is not a number", name);
    double value = member->valuedouble;
    if (!isfinite(value) || value < low || value > high) {
        char what[96];
        snprintf(what, sizeof what, "is %.12g, not in %g..%g", value, low, high);
        return fault(place, what, name);
    }
    *out = value;
    return OK;
}

status json_text(struct json_place place, const cJSON *object, const char *name, const char **out)
{
    *out = NULL;
    const cJSON *member = cJSON_GetObjectItemCaseSensitive(object, name);
    if (!member) return OK;
    if (!cJSON_IsString(member)) return fault(place, "is not a text", name);
    *out = member->valuestring;
    return OK;
}
