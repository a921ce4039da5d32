// An include is emitted at every place that names it, inside a guard of the loader's own, so that
// the preprocessor and not the loader decides which place counts: a file first named in a group
// that #ifdef leaves out still arrives later.
#include "gpu/source.h"

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/embedded.h"

enum { MAX_DEPTH = 16, MAX_TEXT = 4 << 20, NAME_SIZE = 256 };

// A place is told to the compiler as one number, file number * FILE_LINES + line: Mesa forgets the
// second number of #line in most of its messages.
enum { FILE_LINES = 100000 };

struct loader {
    const char *dir;
    struct source *out;
    int stack[MAX_DEPTH]; // file numbers being read, outermost first
    int depth;
};

static void append(struct source *s, const char *text, size_t size)
{
    if (s->size + size + 1 > s->capacity) {
        size_t capacity = 2 * (s->size + size + 1);
        char *grown = NEW_ARRAY(char, capacity);
        if (s->text) memcpy(grown, s->text, s->size);
        free(s->text);
        s->text = grown;
        s->capacity = capacity;
    }
    memcpy(s->text + s->size, text, size);
    s->size += size;
    s->text[s->size] = 0;
}

__attribute__((format(printf, 2, 3))) static void append_line(struct source *s, const char *format,
                                                              ...)
{
    char line[128];
    va_list args;
    va_start(args, format);
    int n = vsnprintf(line, sizeof line, format, args);
    va_end(args);
    append(s, line, (size_t)n);
}

static char *copy_text(const char *text, size_t size)
{
    char *copy = NEW_ARRAY(char, size + 1);
    memcpy(copy, text, size);
    return copy;
}

static status read_embedded(const char *name, char **out)
{
    for (const struct embedded_file *f = embedded_files; f->name; f++) {
        if (strcmp(f->name, name) != 0) continue;
        *out = copy_text(f->text, strlen(f->text));
        return OK;
    }
    return ERR_NOT_FOUND;
}

// The file's text, to be freed. ERR_IO for what is there but is no text of bounded size. Logs
// nothing.
static status read_file(const char *dir, const char *name, char **out)
{
    *out = NULL;
    if (!dir) return read_embedded(name, out);
    size_t path_size = strlen(dir) + strlen(name) + 2;
    char *path = NEW_ARRAY(char, path_size);
    snprintf(path, path_size, "%s/%s", dir, name);
    FILE *file = fopen(path, "rb");
    free(path);
    if (!file) return errno == ENOENT || errno == ENOTDIR ? ERR_NOT_FOUND : ERR_IO;
    char *text = NEW_ARRAY(char, MAX_TEXT + 1);
    size_t size = fread(text, 1, MAX_TEXT, file);
    bool good = !ferror(file) && size < MAX_TEXT && strlen(text) == size;
    fclose(file);
    if (good) *out = copy_text(text, size);
    free(text);
    return good ? OK : ERR_IO;
}

static const char *skip_blanks(const char *p, const char *end)
{
    while (p < end && (*p == ' ' || *p == '\t')) p++;
    return p;
}

// What follows "# word" on a line, NULL when the line is not that directive.
static const char *after_directive(const char *line, const char *end, const char *word)
{
    const char *p = skip_blanks(line, end);
    if (p == end || *p != '#') return NULL;
    p = skip_blanks(p + 1, end);
    size_t length = strlen(word);
    return (size_t)(end - p) >= length && memcmp(p, word, length) == 0 ? p + length : NULL;
}

// A group left out takes the #line after its includes with it, so lines are set anew behind it.
static bool ends_group(const char *line, const char *end)
{
    return after_directive(line, end, "endif") || after_directive(line, end, "el");
}

// The quoted path of an #include line. 0: another line; 1: an include; -1: a malformed include.
static int parse_include(const char *line, const char *end, char name[NAME_SIZE])
{
    const char *p = after_directive(line, end, "include");
    if (!p) return 0;
    p = skip_blanks(p, end);
    if (p == end || *p++ != '"') return -1;
    const char *close = memchr(p, '"', (size_t)(end - p));
    if (!close || close == p || close - p >= NAME_SIZE) return -1;
    memcpy(name, p, (size_t)(close - p));
    name[close - p] = 0;
    return 1;
}

static int file_number(struct source *s, const char *name)
{
    for (int i = 1; i < s->name_count; i++)
        if (strcmp(s->names[i], name) == 0) return i;
    if (s->name_count == SOURCE_MAX_FILES) return -1;
    s->names[s->name_count] = copy_text(name, strlen(name));
    return s->name_count++;
}

static status add_file(struct loader *l, const char *name, const char *from, int from_line);

static void set_line(struct source *s, int number, int line)
{
    append_line(s, "#line %d\n", number * FILE_LINES + line);
}

static status add_include(struct loader *l, const char *name, int number, int line)
{
    struct source *s = l->out;
    int target = file_number(s, name);
    for (int i = 0; i < l->depth; i++)
        if (l->stack[i] == target) return OK;
    append_line(s, "#ifndef PERIGEE_FILE_%d\n#define PERIGEE_FILE_%d\n", target, target);
    status st = add_file(l, name, s->names[number], line);
    append_line(s, "#endif\n");
    return st;
}

static status add_lines(struct loader *l, const char *text, int number)
{
    struct source *s = l->out;
    char name[NAME_SIZE];
    int line = 1;
    set_line(s, number, line);
    for (const char *p = text; *p; line++) {
        const char *end = p + strcspn(p, "\n");
        int include = parse_include(p, end, name);
        if (include < 0) {
            log_error("shader %s:%d: #include needs a \"path\"", s->names[number], line);
            return ERR_FORMAT;
        }
        if (include) {
            status st = add_include(l, name, number, line);
            if (st) return st;
        } else {
            append(s, p, (size_t)(end - p));
            append(s, "\n", 1);
        }
        if (include || ends_group(p, end)) set_line(s, number, line + 1);
        p = end + (*end == '\n');
    }
    return OK;
}

static status log_read_error(const struct loader *l, status s, const char *name, const char *from,
                             int from_line)
{
    const char *where = l->dir ? l->dir : "the built-in shaders";
    const char *what = s == ERR_NOT_FOUND ? "no file" : "unreadable file";
    if (from_line) log_error("shader %s:%d: %s %s in %s", from, from_line, what, name, where);
    else log_error("shader %s: %s in %s", name, what, where);
    return s;
}

static status add_file(struct loader *l, const char *name, const char *from, int from_line)
{
    int number = file_number(l->out, name);
    if (number < 0 || l->depth == MAX_DEPTH || l->out->size > MAX_TEXT) {
        log_error("shader %s:%d: too many or too deep includes at %s", from, from_line, name);
        return ERR_FORMAT;
    }
    char *text;
    status s = read_file(l->dir, name, &text);
    if (s) return log_read_error(l, s, name, from, from_line);
    l->stack[l->depth++] = number;
    s = add_lines(l, text, number);
    l->depth--;
    free(text);
    return s;
}

status source_assemble(const char *dir, const char *entry, const char *defines, struct source *out)
{
    *out = (struct source){.name_count = 1};
    out->names[0] = copy_text("defines", strlen("defines"));
    append_line(out, "#version 450 core\n#line 1\n");
    if (defines) append(out, defines, strlen(defines));
    append(out, "\n", 1);
    struct loader l = {.dir = dir, .out = out};
    status s = add_file(&l, entry, entry, 0);
    if (s) source_deinit(out);
    return s;
}

void source_deinit(struct source *s)
{
    for (int i = 0; i < s->name_count; i++) free(s->names[i]);
    free(s->text);
    *s = (struct source){0};
}

// The first line of a log that speaks of an error, or its first line.
static const char *error_line(const char *log)
{
    const char *error = strcasestr(log, "error");
    if (!error) return log;
    while (error > log && error[-1] != '\n') error--;
    return error;
}

// "0:100023(4): error: ..." (Mesa), "0(100023) : error ..." (NVIDIA), "ERROR: 0:100023: ..."
// (others).
void source_map_message(const struct source *s, const char *log, char *line, size_t line_size)
{
    const char *start = error_line(log);
    const char *end = start + strcspn(start, "\n");
    const char *p = strncmp(start, "ERROR: ", 7) == 0 ? start + 7 : start;
    int place = 0, used = 0;
    bool found = sscanf(p, "%*d:%d%n", &place, &used) == 1;
    if (!found) found = sscanf(p, "%*d(%d)%n", &place, &used) == 1 && used > 0;
    int file = place / FILE_LINES;
    if (found && place >= 0 && file < s->name_count)
        snprintf(line, line_size, "%s:%d%.*s", s->names[file], place % FILE_LINES,
                 (int)(end - p) - used, p + used);
    else snprintf(line, line_size, "%.*s", (int)(end - start), start);
}
