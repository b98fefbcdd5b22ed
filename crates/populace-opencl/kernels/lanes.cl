// lanes.cl - What one work-item computes at once: one joint of a member, or as vectors of LANES, 8 or
// 16, neighbouring joints of a member or one joint of several members. Twin of
// populace-native/src/lanes.rs.
//
// The following files are written once for `Real` and compiled for any LANES. Comparisons yield
// a `Choice` for `? :`, component by component if there are several lanes.

// Functions pass whole vectors. Functions that every joint runs must be inlined; rarely
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
#if LANES == 8
typedef float8 Real;
typedef uint8 Words;
typedef int8 Choice;
#define CONVERT_REAL convert_float8
#define CONVERT_WORDS convert_uint8
#define AS_REAL as_float8
#define AS_INTS as_int8
#define AS_WORDS as_uint8
#define ONLY(lane) ((int8)(0, 1, 2, 3, 4, 5, 6, 7) == (int8)((int)(lane)))
#define LOAD(pointer) vload8(0, pointer)
#define STORE(value, pointer) vstore8(value, 0, pointer)
#else
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
#define LOAD(pointer) vload16(0, pointer)
#define STORE(value, pointer) vstore16(value, 0, pointer)
#endif
// Qualifier of numbers that are used where they stand in memory. Eight lanes have sixteen registers,
// and compilers would read more than these hold and put copies on the stack.
#if LANES == 8
#define IN_MEMORY volatile
#else
#define IN_MEMORY
#endif
// Spans of LANES joints in a block of joints: one or two.
#define SPANS (JOINT_BLOCK / LANES)
#define LANE(value, lane) (((const float *)&(value))[lane])
#define PUT(value, lane, one) (((float *)&(value))[lane] = (one))
#define PUT_WORD(value, lane, one) (((uint *)&(value))[lane] = (one))

#ifndef __has_builtin
#define __has_builtin(name) 0
#endif

// any() tests lane after lane.
#if __has_builtin(__builtin_reduce_or)
#define ANY(choice) (__builtin_reduce_or(choice) != 0)
#else
#define ANY(choice) any(choice)
#endif

// Picks numbers of two vectors by index; those of `q` count from LANES. shuffle2() is compiled to
// loads.
#if __has_builtin(__builtin_shufflevector)
#define PICK(p, q, ...) __builtin_shufflevector(p, q, __VA_ARGS__)
#else
#define PICK(p, q, ...) shuffle2(p, q, (Words)(__VA_ARGS__))
#endif

// Interleaves numbers, or pairs of numbers, of the lower or the upper half of each four numbers.
#if LANES == 8
#define LOWER(p, q) PICK(p, q, 0, 8, 1, 9, 4, 12, 5, 13)
#define UPPER(p, q) PICK(p, q, 2, 10, 3, 11, 6, 14, 7, 15)
#define LOWER_PAIRS(p, q) PICK(p, q, 0, 1, 8, 9, 4, 5, 12, 13)
#define UPPER_PAIRS(p, q) PICK(p, q, 2, 3, 10, 11, 6, 7, 14, 15)
// Joins the lower or the upper half of each vector.
#define LOWER_HALVES(p, q) PICK(p, q, 0, 1, 2, 3, 8, 9, 10, 11)
#define UPPER_HALVES(p, q) PICK(p, q, 4, 5, 6, 7, 12, 13, 14, 15)
#else
#define LOWER(p, q) PICK(p, q, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29)
#define UPPER(p, q) PICK(p, q, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31)
#define LOWER_PAIRS(p, q) PICK(p, q, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29)
#define UPPER_PAIRS(p, q) PICK(p, q, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)
// Joins every second quarter of each vector.
#define EVEN_QUARTERS(p, q) PICK(p, q, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27)
#define ODD_QUARTERS(p, q) PICK(p, q, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31)
#endif

// Transposes a square matrix: first squares of four, then where the squares stand. Processors shuffle
// within four numbers in one step.
INLINE void transpose(Real m[LANES])
{
    Real t[LANES];
#pragma unroll
    for (int i = 0; i < LANES; i += 4) {
        const Real a = LOWER(m[i], m[i + 1]), b = UPPER(m[i], m[i + 1]);
        const Real c = LOWER(m[i + 2], m[i + 3]), d = UPPER(m[i + 2], m[i + 3]);
        t[i] = LOWER_PAIRS(a, c);
        t[i + 1] = UPPER_PAIRS(a, c);
        t[i + 2] = LOWER_PAIRS(b, d);
        t[i + 3] = UPPER_PAIRS(b, d);
    }
#pragma unroll
    for (int i = 0; i < 4; i++) {
#if LANES == 8
        m[i] = LOWER_HALVES(t[i], t[i + 4]);
        m[i + 4] = UPPER_HALVES(t[i], t[i + 4]);
#else
        const Real a = EVEN_QUARTERS(t[i], t[i + 4]), b = ODD_QUARTERS(t[i], t[i + 4]);
        const Real c = EVEN_QUARTERS(t[i + 8], t[i + 12]), d = ODD_QUARTERS(t[i + 8], t[i + 12]);
        m[i] = EVEN_QUARTERS(a, c);
        m[i + 4] = EVEN_QUARTERS(b, d);
        m[i + 8] = ODD_QUARTERS(a, c);
        m[i + 12] = ODD_QUARTERS(b, d);
#endif
    }
}
#endif

// Returns the weighted sum of the lower or of the upper halves of two words, which are signed.
#if LANES == 1

INLINE Real mix_low(Words from, Words to, uint weights)
{
    return convert_float(((int)(from << 16) >> 16) * (int)(weights & 0xffffu)
                         + ((int)(to << 16) >> 16) * (int)(weights >> 16));
}

INLINE Real mix_high(Words from, Words to, uint weights)
{
    return convert_float(((int)from >> 16) * (int)(weights & 0xffffu)
                         + ((int)to >> 16) * (int)(weights >> 16));
}

#else

// Returns the sum of the products of lower halves and of upper halves: one instruction, where
// compilers have a name for it. They do not find it in the plain form.
#if LANES == 16 && defined(__AVX512BW__) && defined(__clang__)

typedef short Halves __attribute__((__vector_size__(64)));

INLINE Real mix_pairs(Words pairs, uint weights)
{
    const Words both = weights;
    return convert_float16(__builtin_astype(
        __builtin_ia32_pmaddwd512(__builtin_astype(pairs, Halves), __builtin_astype(both, Halves)),
        int16));
}

#elif defined(__AVX2__) && defined(__clang__)

typedef short Halves __attribute__((__vector_size__(32)));

INLINE float8 mix_eight(uint8 pairs, uint8 weights)
{
    return convert_float8(
        __builtin_astype(__builtin_ia32_pmaddwd256(__builtin_astype(pairs, Halves),
                                                   __builtin_astype(weights, Halves)),
                         int8));
}

#if LANES == 8
INLINE Real mix_pairs(Words pairs, uint weights) { return mix_eight(pairs, weights); }
#else
INLINE Real mix_pairs(Words pairs, uint weights)
{
    const uint8 both = weights;
    return (float16)(mix_eight(pairs.lo, both), mix_eight(pairs.hi, both));
}
#endif

#else

INLINE Real mix_pairs(Words pairs, uint weights)
{
    return CONVERT_REAL((AS_INTS(pairs << 16) >> 16) * (int)(weights & 0xffffu)
                        + (AS_INTS(pairs) >> 16) * (int)(weights >> 16));
}

#endif

INLINE Real mix_low(Words from, Words to, uint weights)
{
    return mix_pairs((from & 0xffffu) | to << 16, weights);
}

INLINE Real mix_high(Words from, Words to, uint weights)
{
    return mix_pairs(from >> 16 | (to & 0xffff0000u), weights);
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
    for (uint i = 0; i < 16; i += LANES) all->n[i + lane] = LOAD(from + i);
#endif
}

// Turns the numbers of each member into lanes of members, or back.
INLINE void turn_numbers(Numbers *all)
{
#if LANES > 1
    for (uint i = 0; i < 16; i += LANES) transpose(all->n + i);
#endif
}

// Returns four neighbouring numbers of the member in a lane, when numbers are not in lanes.
INLINE float4 numbers_in(const Numbers *all, uint lane, uint first)
{
#if LANES == 1
    return (float4)(all->n[first], all->n[first + 1], all->n[first + 2], all->n[first + 3]);
#else
    return vload4(0, (const float *)&all->n[first / LANES * LANES + lane] + first % LANES);
#endif
}

typedef struct {
    Real x, y, z, w;
} Quat;

typedef struct {
    Real x, y, z;
} Vec3;
