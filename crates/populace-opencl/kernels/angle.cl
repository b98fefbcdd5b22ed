// angle.cl - Angles from sines and cosines, and back, by sums, products and quotients only.
//
// Twin of populace-model/src/math/angle.rs: same arithmetic, same order of operations.

// Returns the angle of (x, y) from +X towards +Y, in radians from -pi to pi; 0 for the origin.
INLINE Real angle_of(Real y, Real x)
{
    const Real up = fabs(y), along = fabs(x);
    const Choice steep = up > along;
    const Real low = steep ? along : up, high = steep ? up : along, ratio = low / high;
    const Choice far = ratio > (Real)(0.25f);
    const Real a = far ? (ratio - 0.5f) / (1.0f + 0.5f * ratio) : ratio, s = a * a;
    const Real series =
        1.0f
        + s
              * (-1.0f / 3.0f
                 + s * (0.2f + s * (-1.0f / 7.0f + s * (1.0f / 9.0f + s * (-1.0f / 11.0f)))));
    const Real near = a * series + (far ? (Real)(0.4636476f) : (Real)(0.0f));
    const Real upper = steep ? QUARTER_TURN - near : near;
    const Real right = x < (Real)(0.0f) ? HALF_TURN - upper : upper;
    const Real angle = y < (Real)(0.0f) ? -right : right;
    return high < (Real)(LEAST_SQUARE) ? (Real)(0.0f) : angle;
}

// Computes sine and cosine of an angle in radians from -pi to pi.
INLINE void sin_cos(Real angle, Real *sine, Real *cosine)
{
    const Real x = 0.5f * angle, s = x * x;
    const Real half_sine =
        x
        * (1.0f
           + s
                 * (-1.0f / 6.0f
                    + s
                          * (1.0f / 120.0f
                             + s
                                   * (-1.0f / 5040.0f
                                      + s * (1.0f / 362880.0f - s * (1.0f / 39916800.0f))))));
    const Real half_cosine =
        1.0f
        + s
              * (-0.5f
                 + s
                       * (1.0f / 24.0f
                          + s
                                * (-1.0f / 720.0f
                                   + s
                                         * (1.0f / 40320.0f
                                            + s
                                                  * (-1.0f / 3628800.0f
                                                     + s * (1.0f / 479001600.0f))))));
    *sine = 2.0f * half_sine * half_cosine;
    *cosine = 1.0f - 2.0f * half_sine * half_sine;
}
