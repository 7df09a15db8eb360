/* talus.h alone, in strict C99: it compiles without a warning, and its init functions fill what they promise. */
#include "talus.h"

#include <stdio.h>
#include <string.h>

static int failures = 0;

static void check(int good, const char *what) {
    if (!good) {
        fprintf(stderr, "failed: %s\n", what);
        ++failures;
    }
}

#define CHECK(condition) check((condition) != 0, #condition)

int main(void) {
    talus_settings settings;
    talus_engine *engine = NULL;

    CHECK(talus_version() == TALUS_VERSION_NUMBER);
    CHECK(strcmp(talus_status_string(TALUS_OK), "TALUS_OK") == 0);
    CHECK(strlen(talus_build_info()) > 0);

    memset(&settings, 0x5a, sizeof settings);
    CHECK(talus_settings_init(&settings) == TALUS_OK);
    CHECK(settings.struct_size == sizeof settings);
    CHECK(settings.laws.struct_size == sizeof settings.laws);
    CHECK(settings.header_version == TALUS_VERSION_NUMBER);
    CHECK(settings.threads == 1);

    /* Without a domain and a time step nothing can be created, and the text says so. */
    CHECK(talus_engine_create(&settings, &engine) == TALUS_ERR_ARGUMENT);
    CHECK(engine == NULL);
    CHECK(strlen(talus_message()) > 0);
    talus_engine_destroy(NULL);
    return failures != 0;
}
