// lanes.cl - What one work-item computes at once: one joint, or sixteen neighbouring joints of a
// member as vectors. Twin of populace-native/src/lanes.rs.
//
// The following files are written once for `Real` and compiled for either LANES. Comparisons yield
// a `Choice` for `? :`, component by component if there are several lanes.

// Functions pass whole vectors of sixteen. Functions that every joint runs must be inlined; rarely
// used ones must not take registers from them. With one lane everything is inlined, since a GPU
// would pass arguments through memory.
#define INLINE static inline __attribute__((always_inline))
// Large and rarely used functions are always called: inlined copies would dominate compile time.
#define SELDOM static __attribute__((noinline))

#if LANES == 1
#define BATCH 1
#define APART INLINE
#ifdef CALLS // the device has cheap calls
#define APART_STEP SELDOM
#else
#define APART_STEP INLINE
#endif
typedef float Real;
typedef uint Words;
typedef int Choice;
#define CONVERT_REAL convert_float
#define AS_REAL as_float
#define AS_INTS as_int
#define AS_WORDS as_uint
#define ONLY(lane) 1
#define LANE(value, lane) (value)
#define PUT(value, lane, one) ((value) = (one))
#define ANY(choice) (choice)
#define LOAD(pointer) (*(pointer))
#define STORE(value, pointer) (*(pointer) = (value))
#else
#define BATCH MEMBERS_PER_BATCH
#define APART __attribute__((noinline))
#define APART_STEP static __attribute__((noinline))
typedef float16 Real;
typedef uint16 Words;
typedef int16 Choice;
#define CONVERT_REAL convert_float16
#define AS_REAL as_float16
#define AS_INTS as_int16
#define AS_WORDS as_uint16
#define ONLY(lane)                                                                                 \
    ((int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) == (int16)((int)(lane)))
#define ANY(choice) any(choice)
#define LANE(value, lane) (((const float *)&(value))[lane])
#define PUT(value, lane, one) (((float *)&(value))[lane] = (one))
#define LOAD(pointer) vload16(0, pointer)
#define STORE(value, pointer) vstore16(value, 0, pointer)

// Returns words[lanes[i]] in each lane i. Only the low four bits of a lane index count.
INLINE Words permute(Words words, Words lanes)
{
#if defined(__AVX512F__) && defined(__clang__)
    // One instruction; shuffle() is compiled to sixteen loads.
    typedef int Ints __attribute__((__vector_size__(64)));
    return __builtin_astype(
        __builtin_ia32_permvarsi512(__builtin_astype(words, Ints), __builtin_astype(lanes, Ints)),
        Words);
#else
    return shuffle(words, lanes);
#endif
}
#endif

typedef struct {
    Real x, y, z, w;
} Quat;

typedef struct {
    Real x, y, z;
} Vec3;
