/* hide_avx512.c - Hides AVX-512 from PoCL's compiler, to measure what it makes for AVX2 on a processor
 * that has both. POCL_LLVM_CPU_NAME is not enough: PoCL adds the features of the host.
 *
 *     cc -shared -fPIC -o hide_avx512.so hide_avx512.c -ldl
 *     LD_PRELOAD=./hide_avx512.so POCL_CACHE_DIR="$PWD/avx2-cache" ... populace bench ...
 *
 * LLVM is the name of the library that PoCL uses, by default that of Debian 12. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifndef LLVM
#define LLVM "libLLVM-15.so.1"
#endif

/* llvm::StringMap<bool>. An entry is the length of its key, its value, and the key. */
struct entry {
    size_t length;
    bool value;
    char padding[7];
    char key[];
};

struct map {
    struct entry **entries;
    unsigned count;
};

/* llvm::sys::getHostCPUFeatures(StringMap<bool> &) */
#define FEATURES _ZN4llvm3sys18getHostCPUFeaturesERNS_9StringMapIbNS_15MallocAllocatorEEE
#define TEXT(name) #name
#define NAME_OF(name) TEXT(name)

bool FEATURES(struct map *features)
{
    void *library = dlopen(LLVM, RTLD_LAZY);
    bool (*find)(struct map *) = library ? dlsym(library, NAME_OF(FEATURES)) : NULL;
    if (!find || !find(features)) return false;
    for (unsigned i = 0; i < features->count; i++) {
        struct entry *entry = features->entries[i];
        /* The last addresses mark entries that were removed. */
        if (!entry || (uintptr_t)entry >= (uintptr_t)-4096) continue;
        if (!strncmp(entry->key, "avx512", 6)) entry->value = false;
    }
    return true;
}
