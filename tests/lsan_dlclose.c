// LeakSanitizer cannot name a block whose module has been unloaded, so Mesa's driver, which keeps a
// few bytes to the end of the process, would fail every test. Test programs built with a sanitizer
// therefore never unload a module.
int dlclose(void *handle);

__attribute__((visibility("default"))) int dlclose(void *handle)
{
    (void)handle;
    return 0;
}
