// One formatted line at a time; the lock covers only the hand-over of a finished line.
#include "base/log.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "base/status.h"

enum { LINE_SIZE = 1024 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static log_sink current_sink;
static void *current_user;
static atomic_int current_level = LOG_INFO;
static _Thread_local char last_error[LINE_SIZE];

static void emit(enum log_level level, const char *format, va_list args)
{
    static const char *const prefix[] = {"error: ", "warning: ", "", ""};
    char line[LINE_SIZE];
    vsnprintf(line, sizeof line, format, args);
    if (level == LOG_ERROR) memcpy(last_error, line, sizeof line);
    if ((int)level > atomic_load(&current_level)) return;
    pthread_mutex_lock(&lock);
    if (current_sink) current_sink(current_user, level, line);
    else fprintf(stderr, "perigee: %s%s\n", prefix[level], line);
    pthread_mutex_unlock(&lock);
}

void log_set_sink(log_sink sink, void *user)
{
    pthread_mutex_lock(&lock);
    current_sink = sink;
    current_user = user;
    pthread_mutex_unlock(&lock);
}

void log_set_level(enum log_level level)
{
    atomic_store(&current_level, (int)level);
}

const char *log_last_error(void)
{
    return last_error;
}

#define LOG_FUNCTION(name, level)                                                                  \
    void name(const char *format, ...)                                                             \
    {                                                                                              \
        va_list args;                                                                              \
        va_start(args, format);                                                                    \
        emit(level, format, args);                                                                 \
        va_end(args);                                                                              \
    }

LOG_FUNCTION(log_error, LOG_ERROR)
LOG_FUNCTION(log_warn, LOG_WARN)
LOG_FUNCTION(log_info, LOG_INFO)
LOG_FUNCTION(log_debug, LOG_DEBUG)

const char *status_text(status s)
{
    switch (s) {
    case OK:
        return "ok";
    case ERR_ARGUMENT:
        return "impossible value";
    case ERR_IO:
        return "cannot read or write";
    case ERR_FORMAT:
        return "malformed content";
    case ERR_VERSION:
        return "wrong schema version";
    case ERR_MEMORY:
        return "out of memory";
    case ERR_GPU:
        return "no usable OpenGL";
    case ERR_NOT_FOUND:
        return "not found";
    case ERR_CANCELLED:
        return "cancelled";
    case ERR_TIMEOUT:
        return "not complete in time";
    case ERR_UNSUPPORTED:
        return "not supported";
    case ERR_PENDING:
        return "on its way";
    }
    return "unknown status";
}
