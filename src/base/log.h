// Messages to the user. One line each, to standard error unless a sink is set. Any thread.
#ifndef PERIGEE_BASE_LOG_H
#define PERIGEE_BASE_LOG_H

enum log_level { LOG_ERROR, LOG_WARN, LOG_INFO, LOG_DEBUG };

typedef void (*log_sink)(void *user, enum log_level level, const char *line);

// Replaces the sink (NULL: standard error again). Call before threads start.
void log_set_sink(log_sink sink, void *user);

// Messages above this level are dropped. Default LOG_INFO.
void log_set_level(enum log_level level);

// The last LOG_ERROR line of the calling thread, "" when there was none.
const char *log_last_error(void);

__attribute__((format(printf, 1, 2))) void log_error(const char *format, ...);
__attribute__((format(printf, 1, 2))) void log_warn(const char *format, ...);
__attribute__((format(printf, 1, 2))) void log_info(const char *format, ...);
__attribute__((format(printf, 1, 2))) void log_debug(const char *format, ...);

#endif
