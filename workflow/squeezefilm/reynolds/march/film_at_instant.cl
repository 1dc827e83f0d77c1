/* The film at one instant: the rate of its mass, and the Jacobian of an implicit stage.
 *
 * Unknown: the mass excess y = HP − 1 at the inner nodes. In the mass the equation is a rate,
 *
 *     dy/dT = f(T, y) = [div(H³ P grad P) + what other terms add] / σ,
 *
 * with no dH/dT in it: a surface that starts with a jump of velocity gives no jump of the rate,
 * every stage knows the rim exactly by p = (y − (H − 1)) / H = 0 there, and in w = δy the operator
 * varies like H²P only. Counting from 1 keeps the digits of small films.
 * As in film_over_period.cl, with v = H^(3/2) p (1 + p/2): div(H³ P grad P) = H^(3/2) (Δv − q v).
 *
 * IMPLICIT: w − c df/dy w is preconditioned by the inverse of 1 − c D Δ / σ, D = mean of H²P,
 * diagonal in the modal basis; c, the stage's share of a step, is kept with the film.
 * Compiled after the sources of the scene's terms, which add their lines at the hooks TERMS_….
 */

/* The gap H = 1 + excursion · s, and what depends on it alone. Each work-item reads only what it has
 * written itself, so that no barrier is needed, which a caller could not make conditional. */
static void set_gap(const Grid *g, Film *film, double excursion)
{
    film->excursion = excursion;
    FOR_EACH(i, g->count4)
    {
        const double4 gap = 1.0 + excursion * film->amplitude[i], inverse = 1.0 / gap;
        film->inverse_gap[i] = inverse;
        film->power[i] = gap * sqrt(gap);
        film->potential[i] =
            1.5 * excursion * inverse *
            (film->laplacian[i] + 0.5 * excursion * inverse *
                                      (film->slope_x[i] * film->slope_x[i] +
                                       film->slope_y[i] * film->slope_y[i]));
    }
}

/* out = f(T, y) for the gap as set, and the overpressure. IMPLICIT: sets the Jacobian too. */
static void rate(const Grid *g, Film *film, field y, field out, __local double *scratch)
{
    matrix4 mass = (matrix4)y;
    field4 v = (field4)film->work_a, r = (field4)out;
    double4 diffusivity = 0.0;
    FOR_EACH(i, g->count4)
    {
        const double4 p =
            (mass[i] - film->excursion * film->amplitude[i]) * film->inverse_gap[i];
        v[i] = film->power[i] * p * (1.0 + 0.5 * p);
        film->overpressure[i] = p;
#ifdef IMPLICIT
        film->response[i] = film->power[i] * film->inverse_gap[i] * (1.0 + p);
        diffusivity += film->response[i] * film->power[i];
#endif
    }
    SYNC;
    along_x(g, g->laplace_x, film->work_a, out, 0);
    along_y(g, g->laplace_y, film->work_a, out, 1);
    const double inverse_sigma = 1.0 / film->sigma;
    FOR_EACH(i, g->count4)
        r[i] = inverse_sigma * film->power[i] * (r[i] - film->potential[i] * v[i]);
    SYNC;
    TERMS_RATE(g, film, y, film->work_a, out)
#ifdef IMPLICIT
    film->diffusivity = sum_over_group(sum_of(diffusivity), scratch) / g->count;
#endif
}

#ifdef IMPLICIT
/* Solve (1 − c D Δ / σ) w = r in place. */
static void precondition(const Grid *g, const Film *film, field r)
{
    along_x(g, g->to_modes_x, r, film->work_a, 0);
    along_y(g, g->to_modes_y, film->work_a, r, 0);
    const double scale = film->stage * film->diffusivity / film->sigma;
    FOR_EACH(i, g->count) r[i] /= 1.0 - scale * g->eigenvalues[i];
    SYNC;
    along_x(g, g->modes_x, r, film->work_a, 0);
    along_y(g, g->modes_y, film->work_a, r, 0);
}

/* out = preconditioned (1 − c df/dy) w. */
static void apply_jacobian(const Grid *g, Film *film, field w, field out)
{
    field4 v = (field4)film->work_a, r = (field4)out;
    matrix4 from = (matrix4)w;
    FOR_EACH(i, g->count4) v[i] = film->response[i] * from[i];
    SYNC;
    along_x(g, g->laplace_x, film->work_a, out, 0);
    along_y(g, g->laplace_y, film->work_a, out, 1);
    const double scale = film->stage / film->sigma;
    FOR_EACH(i, g->count4)
        r[i] = from[i] - scale * film->power[i] * (r[i] - film->potential[i] * v[i]);
    SYNC;
    TERMS_RATE_RESPONSE(g, film, w, film->work_a, out)
    precondition(g, film, out);
}
#endif
