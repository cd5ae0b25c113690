/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define P_UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define P_UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int P_is_unit2(float length2)
{
    return length2 >= P_UNIT_LEAST2 && length2 <= P_UNIT_MOST2;
}
