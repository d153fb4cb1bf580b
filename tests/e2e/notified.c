/* A small service manager: it runs a program with NOTIFY_SOCKET, waits for READY=1, ends the program with
 * SIGTERM, and waits for STOPPING=1 and status 0. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

static int await(int fd, const char *word)
{
    char text[256];
    ssize_t count = recv(fd, text, sizeof(text) - 1, 0);

    if (count < 0) count = 0;
    text[count] = '\0';
    if (!strcmp(text, word)) return 1;
    fprintf(stderr, "'%s' came, where %s was expected\n", text, word);
    return 0;
}

int main(int argc, char **argv)
{
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    struct timeval patience = {.tv_sec = 3600};
    int fd = socket(AF_UNIX, SOCK_DGRAM, 0), status, good;
    pid_t child;

    if (argc < 3) return 2;
    snprintf(name.sun_path, sizeof(name.sun_path), "%s", argv[1]);
    if (fd < 0 || bind(fd, (struct sockaddr *)&name, sizeof(name))) return 2;
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    setenv("NOTIFY_SOCKET", argv[1], 1);
    child = fork();
    if (child == 0) {
        execv(argv[2], argv + 2);
        _exit(127);
    }
    good = await(fd, "READY=1");
    kill(child, SIGTERM);
    good = good && await(fd, "STOPPING=1");
    return waitpid(child, &status, 0) == child && good && status == 0 ? 0 : 1;
}
