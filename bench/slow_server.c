// A thread a connection; connections are kept.
#include "slow_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { REQUEST_SIZE = 4096 };

static pid_t child;

static void answer(int client, const char *path)
{
    char head[160];
    struct stat info = {0};
    int file = strstr(path, "..") ? -1 : open(path, O_RDONLY);
    bool found = file >= 0 && fstat(file, &info) == 0 && S_ISREG(info.st_mode);
    int n = snprintf(head, sizeof head, "HTTP/1.1 %s\r\nContent-Length: %lld\r\n\r\n",
                     found ? "200 OK" : "404 Not Found", found ? (long long)info.st_size : 0LL);
    if (write(client, head, (size_t)n) != n) found = false;
    for (off_t at = 0; found && at < info.st_size;)
        if (sendfile(client, file, &at, (size_t)(info.st_size - at)) <= 0) break;
    if (file >= 0) close(file);
}

static void *serve(void *arg)
{
    int client = (int)(long)arg;
    char request[REQUEST_SIZE], path[REQUEST_SIZE];
    size_t used = 0;
    for (ssize_t n; (n = read(client, request + used, sizeof request - 1 - used)) > 0;) {
        used += (size_t)n;
        request[used] = '\0';
        if (!strstr(request, "\r\n\r\n")) continue;
        int ms = 0;
        if (sscanf(request, "GET /%d/%4000s", &ms, path) != 2) break;
        usleep((useconds_t)ms * 1000);
        answer(client, path);
        used = 0;
    }
    close(client);
    return NULL;
}

static int listen_anywhere(struct sockaddr_in *at)
{
    socklen_t size = sizeof *at;
    int s = socket(AF_INET, SOCK_STREAM, 0);
    *at = (struct sockaddr_in){.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    if (s < 0 || bind(s, (struct sockaddr *)at, size) || listen(s, 128) ||
        getsockname(s, (struct sockaddr *)at, &size))
        return -1;
    return s;
}

int slow_server_start(const char *folder)
{
    struct sockaddr_in at;
    int s = listen_anywhere(&at);
    if (s < 0) return 0;
    child = fork();
    if (child == 0) {
        signal(SIGPIPE, SIG_IGN);
        if (chdir(folder)) _exit(1);
        for (;;) {
            int client = accept(s, NULL, NULL);
            pthread_t thread;
            if (client < 0) continue;
            if (pthread_create(&thread, NULL, serve, (void *)(long)client)) close(client);
            else pthread_detach(thread);
        }
    }
    close(s);
    return child > 0 ? ntohs(at.sin_port) : 0;
}

void slow_server_stop(void)
{
    if (child <= 0) return;
    kill(child, SIGTERM);
    waitpid(child, NULL, 0);
    child = 0;
}
