/* Loops and sums by the work-items of one work-group; products are in vectors.cl.
 *
 * With WORK_ITEMS == 1 (a processor core per group) loops are plain loops and need no barrier.
 */

#if WORK_ITEMS == 1
#define SYNC
#define FOR_EACH(index, count) for (int index = 0; index < (count); index++)
/* Four instants at a time: `i` counts double4 of the field, `t` those of the period. */
#define FOR_EACH_POINT(g, row, t, i)                 \
    for (int row = 0, i = 0; row < (g)->rows; row++) \
        for (int t = 0; t < (g)->nt4; t++, i++)
#else
#define SYNC barrier(CLK_GLOBAL_MEM_FENCE | CLK_LOCAL_MEM_FENCE)
#define FOR_EACH(index, count) \
    for (int index = get_local_id(0); index < (count); index += WORK_ITEMS)
#define FOR_EACH_POINT(g, row, t, i)                                                   \
    for (int i = get_local_id(0), row = i / (g)->nt4, t = i % (g)->nt4; i < (g)->count4; \
         i += WORK_ITEMS, row = i / (g)->nt4, t = i % (g)->nt4)
#endif

typedef __global double *field;
typedef __global const double *matrix;
typedef __global double4 *field4;
typedef __global const double4 *matrix4;

/* The larger number, or what is none if either is: it must not get lost. */
static double greater(double a, double b) { return a > b || a != a ? a : b; }

/* Sum or largest of one number per work-item, known to all of them; the order of the sum is fixed.
 * Global memory is in step afterwards too: the next loop may share a field among the items in another
 * way. */
static double over_group(double part, int largest, __local double *scratch)
{
#if WORK_ITEMS == 1
    return part;
#else
    const int item = get_local_id(0);
    scratch[item] = part;
    SYNC;
    for (int span = WORK_ITEMS / 2; span > 0; span /= 2) {
        if (item < span) {
            const double other = scratch[item + span];
            scratch[item] = largest ? greater(scratch[item], other) : scratch[item] + other;
        }
        SYNC;
    }
    const double all = scratch[0];
    SYNC;
    return all;
#endif
}
static double sum_over_group(double part, __local double *scratch) { return over_group(part, 0, scratch); }
static double max_over_group(double part, __local double *scratch) { return over_group(part, 1, scratch); }

static double sum_of(double4 v) { return (v.x + v.y) + (v.z + v.w); }

static double max_of(double4 v) { return greater(greater(v.x, v.y), greater(v.z, v.w)); }

static double4 larger(double4 a, double4 b) { return ((a > b) | (a != a)) ? a : b; }
