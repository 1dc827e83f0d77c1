/* GMRES for the film's linear systems, by the work-items of one work-group. Compiled between a film
 * (Grid, Film and its apply_jacobian) and the method that solves for it. */

/* The sum of some vectors, each times a number, in the first of them. */
static void combine(vector vectors, int length, matrix factors, int some, int count4)
{
    scale_field(vectors, factors[0], count4);
    for (int k = 1; k < some; k++)
        subtract(vectors, -factors[k], vectors + k * length, count4);
}

/* GMRES with modified Gram–Schmidt and Givens rotations for a preconditioned system whose product
 * is apply_jacobian. On entry basis[0] holds the right-hand side, of norm `beta`; on exit the
 * solution. Vectors are of the type `real`, all that is small is double. Norms are root sums of
 * squares over `weight`. Stops at the norm `target` of what is left or after `most` steps; an
 * unfinished solution is still a good Newton step. `small` has room for (most + 4)(most + 1)
 * numbers. Returns the number of steps, and in `left_over` that norm. */
static int gmres(const Grid *g, Film *film, vector basis, field small, double beta,
                 double target, int most, double weight, double *left_over, __local double *scratch)
{
    const int lead = most + 1;
    field hessenberg = small, right = hessenberg + lead * most, cosines = right + lead,
          sines = cosines + most;
    scale_field(basis, 1.0 / beta, g->length4);
    double left = beta;
    int steps = 0;
    if (get_local_id(0) == 0)
        right[0] = beta;
    while (steps < most && left > target) {
        vector next = basis + (steps + 1) * g->length;
        apply_jacobian(g, film, basis + steps * g->length, next);
        field column = hessenberg + steps * lead;
        double overlap = dot_product(basis, next, g->length4, scratch) / weight;
        for (int j = 0; j <= steps; j++) {
            if (get_local_id(0) == 0)
                column[j] = overlap;
            vector old = basis + j * g->length, other = j < steps ? old + g->length : next;
            overlap = subtract_and_project(next, overlap, old, other, g->length4, scratch) / weight;
        }
        const double length = sqrt(overlap);
        if (length > 0.0)
            scale_field(next, 1.0 / length, g->length4);
        if (get_local_id(0) == 0) {
            for (int j = 0; j < steps; j++) {
                const double upper = column[j], lower = column[j + 1];
                column[j] = cosines[j] * upper + sines[j] * lower;
                column[j + 1] = cosines[j] * lower - sines[j] * upper;
            }
            const double diagonal = hypot(column[steps], length);
            cosines[steps] = column[steps] / diagonal;
            sines[steps] = length / diagonal;
            column[steps] = diagonal;
            right[steps + 1] = -sines[steps] * right[steps];
            right[steps] *= cosines[steps];
        }
        SYNC;
        left = fabs(right[steps + 1]);
        steps++;
        if (!(length > 0.0) || !isfinite(left))
            break;
    }
    if (get_local_id(0) == 0)
        for (int j = steps - 1; j >= 0; j--) {
            for (int k = j + 1; k < steps; k++)
                right[j] -= hessenberg[k * lead + j] * right[k];
            right[j] /= hessenberg[j * lead + j];
        }
    SYNC;
    if (steps > 0)
        combine(basis, g->length, right, steps, g->length4);
    *left_over = left;
    return steps;
}
