// real.cl - Scalar arithmetic in lanes, by + - * / only.
//
// Twin of populace-model/src/math/real.rs: same arithmetic, same order of operations.

INLINE Real mix_real(Real a, Real b, float t) { return a + (b - a) * t; }

// Returns 1 / sqrt(x) by + - * only: a first guess from the exponent, then three steps of Newton's
// method. Every device rounds it the same, and on a CPU it costs less than a root and a quotient. x
// must be positive and normal.
INLINE Real inverse_sqrt(Real x)
{
    const Real half_x = 0.5f * x;
    Real y = AS_REAL((int)INVERSE_SQRT_BITS - (AS_INTS(x) >> 1));
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    return y;
}

INLINE Real square_root(Real x)
{
    return x > (Real)(LEAST_SQUARE) ? x * inverse_sqrt(x) : (Real)(0.0f);
}

// inverse_sqrt() of one number.
INLINE float inverse_root(float x)
{
    const float half_x = 0.5f * x;
    float y = as_float((int)INVERSE_SQRT_BITS - (as_int(x) >> 1));
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    y = y * (1.5f - half_x * y * y);
    return y;
}

INLINE float root(float x) { return x > LEAST_SQUARE ? x * inverse_root(x) : 0.0f; }
