// lanes.cl - What one work-item computes at once: one joint of a member, or as vectors sixteen
// neighbouring joints of a member or one joint of sixteen members. Twin of populace-native/src/lanes.rs.
//
// The following files are written once for `Real` and compiled for either LANES. Comparisons yield
// a `Choice` for `? :`, component by component if there are several lanes.

// Functions pass whole vectors of sixteen. Functions that every joint runs must be inlined; rarely
// used ones must not take registers from them. With one lane everything is inlined, since a GPU
// would pass arguments through memory.
#define INLINE static inline __attribute__((always_inline))
// Large and rarely used functions are called where a device has cheap calls: inlined copies would
// dominate compile time.

#if LANES == 1
#define APART INLINE
#ifdef CALLS
#define SELDOM static __attribute__((noinline))
#else
#define SELDOM INLINE
#endif
typedef float Real;
typedef uint Words;
typedef int Choice;
#define CONVERT_REAL convert_float
#define CONVERT_WORDS convert_uint
#define AS_REAL as_float
#define AS_INTS as_int
#define AS_WORDS as_uint
#define ONLY(lane) 1
#define LANE(value, lane) (value)
#define PUT(value, lane, one) ((value) = (one))
#define PUT_WORD(value, lane, one) ((value) = (one))
#define ANY(choice) (choice)
#define LOAD(pointer) (*(pointer))
#define STORE(value, pointer) (*(pointer) = (value))
#else
#define APART __attribute__((noinline))
#define SELDOM static __attribute__((noinline))
typedef float16 Real;
typedef uint16 Words;
typedef int16 Choice;
#define CONVERT_REAL convert_float16
#define CONVERT_WORDS convert_uint16
#define AS_REAL as_float16
#define AS_INTS as_int16
#define AS_WORDS as_uint16
#define ONLY(lane)                                                                                 \
    ((int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) == (int16)((int)(lane)))
#define ANY(choice) any(choice)
#define LANE(value, lane) (((const float *)&(value))[lane])
#define PUT(value, lane, one) (((float *)&(value))[lane] = (one))
#define PUT_WORD(value, lane, one) (((uint *)&(value))[lane] = (one))
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

// Transposes a 16 x 16 matrix by four perfect shuffles.
INLINE void transpose(float16 m[16])
{
    float16 t[16];
#pragma unroll
    for (int round = 0; round < 4; round++) {
#pragma unroll
        for (int i = 0; i < 8; i++) {
            const float16 p = m[i], q = m[i + 8];
            t[2 * i] = (float16)(p.s0, q.s0, p.s1, q.s1, p.s2, q.s2, p.s3, q.s3, p.s4, q.s4, p.s5,
                                 q.s5, p.s6, q.s6, p.s7, q.s7);
            t[2 * i + 1] = (float16)(p.s8, q.s8, p.s9, q.s9, p.sa, q.sa, p.sb, q.sb, p.sc, q.sc,
                                     p.sd, q.sd, p.se, q.se, p.sf, q.sf);
        }
#pragma unroll
        for (int i = 0; i < 16; i++) m[i] = t[i];
    }
}
#endif

// Sixteen numbers of each member, in lanes.
typedef struct {
    Real n[16];
} Numbers;

INLINE Numbers no_numbers(void)
{
    Numbers none;
    for (uint i = 0; i < 16; i++) none.n[i] = 0.0f;
    return none;
}

// Puts sixteen neighbouring numbers of the member in a lane. Numbers are in lanes only after
// turn_numbers().
INLINE void put_numbers(Numbers *all, uint lane, __global const float *from)
{
#if LANES == 1
    for (uint i = 0; i < 16; i++) all->n[i] = from[i];
#else
    all->n[lane] = vload16(0, from);
#endif
}

// Turns the numbers of each member into lanes of members, or back.
INLINE void turn_numbers(Numbers *all)
{
#if LANES > 1
    transpose(all->n);
#endif
}

// Returns four neighbouring numbers of the member in a lane, when numbers are not in lanes.
INLINE float4 numbers_in(const Numbers *all, uint lane, uint first)
{
#if LANES == 1
    return (float4)(all->n[first], all->n[first + 1], all->n[first + 2], all->n[first + 3]);
#else
    return vload4(0, (const float *)&all->n[lane] + first);
#endif
}

typedef struct {
    Real x, y, z, w;
} Quat;

typedef struct {
    Real x, y, z;
} Vec3;
