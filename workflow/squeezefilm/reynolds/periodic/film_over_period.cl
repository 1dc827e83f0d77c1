/* The film over one period: the Reynolds equation collocated in space and time.
 *
 * Unknown: the overpressure p = P − 1, zero on the rim. The mass flux is a sum of FLOW_TERMS terms
 * c_k H^a grad g_k(P) with a = 3 − k and dg_k/dP = ρ^(1−k): the viscous flow, and the corrections
 * of a rarefied gas in powers of the Knudsen number. With v = H^(a/2) g(P) each term needs second
 * derivatives only (Liouville's transformation),
 *
 *     div(H^a grad g) = H^(a/2) (Δv − q v),   q = Δ(H^(a/2)) / H^(a/2),
 *
 * and the equation reads, with the density ρ(P) relative to ambient,
 *
 *     Σ_k c_k div(H^(3−k) grad g_k) − σ d(Hρ)/dT + what other terms add = 0.
 *
 * Newton's correction is sought as a mass perturbation w = δ(Hρ): the stiff time term then keeps a
 * constant coefficient. GMRES is preconditioned from the left by the inverse of D Δ − σ A d/dT times
 * A, where D is the mean diffusivity over the mean gap and A the resistance that it leaves to the
 * gas (time_modes.py), in a basis of space and time in which it is diagonal. Its vectors are stored
 * in that basis, where the time term is diagonal too, so that its residual norm estimates the error
 * in w itself.
 *
 * Compiled after the sources of the scene's terms. One of them may have its own in place of the
 * GAS_LAW or of the PRECONDITIONER here; all add their lines at the hooks TERMS_…. A term may have
 * fields that are unknown beside p: they lie behind p, behind w and behind each residual, and the
 * term's lines precondition them.
 */

/* H^(a/2) for a = 3 − k. */
static double4 half_power(double4 gap, int k)
{
    return k == 0 ? gap * sqrt(gap) : k == 1 ? gap : k == 2 ? sqrt(gap) : (double4)(1.0);
}

/* Density ρ(P) − 1 and its derivative; g_k(P) − g_k(1) and its derivative. All exact for small p. */
#ifndef GAS_LAW
static double4 density_rise(const Film *film, double4 p) { return p; }
static double4 density_slope(const Film *film, double4 p) { return (double4)(1.0); }
static double4 flow_potential(const Film *film, double4 p, int k)
{
    return k == 0 ? p * (1.0 + 0.5 * p) : k == 1 ? p : k == 2 ? log1p(p) : p / (1.0 + p);
}
static double4 flow_slope(const Film *film, double4 p, int k)
{
    return k == 0 ? 1.0 + p : k == 1 ? (double4)(1.0) : k == 2 ? 1.0 / (1.0 + p)
                                                               : 1.0 / ((1.0 + p) * (1.0 + p));
}
#endif

/* What depends on the gap alone: H^(a/2) and the potential q of each flow term. */
static void set_gap(const Grid *whole_grid, const Film *whole_film)
{
    AS_COPIES(whole_grid, whole_film)
    for (int k = 0; k < FLOW_TERMS; k++) {
        const double half_exponent = 0.5 * (3 - k);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = gap_at(g, film, row, t), over_gap = 1.0 / gap;
            const double4 along_x = beyond_even(g, film, film->slope_x, row, t) * over_gap;
            const double4 along_y = beyond_even(g, film, film->slope_y, row, t) * over_gap;
            const double4 power = half_power(gap, k);
            const double4 potential =
                half_exponent *
                (beyond_even(g, film, film->laplacian, row, t) * over_gap +
                 (half_exponent - 1.0) * (along_x * along_x + along_y * along_y));
            film->gap_power[k][i] = power;
            film->potential[k][i] = potential;
            store4(power, i, film->power[k]);
            store4(potential, i, film->bend[k]);
        }
    }
    SYNC;
}

/* A pair of modes in time has its coefficients (c, s) beside each other; the first pair are the mean
 * and the last cosine, which both have no rate. A d/dT maps (c, s) to (g c + k s, g s − k c), with the
 * pair's decay g and speed k; without inertia g = 0, and with the mean gap at rest k counts
 * harmonics. */
#ifndef PRECONDITIONER
/* What solves (D Δ − σ A d/dT) u = (c, s) at this state: two unknowns by two, for each pair. */
static void set_preconditioner(const Grid *whole_grid, const Film *whole_film)
{
    AS_COPIES(whole_grid, whole_film)
    FOR_EACH_POINT(g, row, t, i)
    {
        const double2 decay = film->sigma * (double2)(g->decays[2 * t], g->decays[2 * t + 1]);
        const double2 speed = film->sigma * (double2)(g->speeds[2 * t], g->speeds[2 * t + 1]);
        const double diffusion = film->diffusivity * g->eigenvalues[row];
        const double2 own = diffusion - decay;
        const double2 scale = 1.0 / (own * own + speed * speed);
        const double2 share = scale * own, other = scale * speed;
        store4((double4)(diffusion), i, film->diffusion);
        /* Numbers one by one: Oclgrind does not follow vectors put together of shorter ones. */
        store4((double4)(share.x, share.x, share.y, share.y), i, film->own_share);
        store4((double4)(other.x, -other.x, other.y, -other.y), i, film->other_share);
    }
}

/* Solve (D Δ − σ A d/dT) u = modal in place. */
static void precondition(const Grid *g, const Film *film, vector modal)
{
    __global lanes *m = (__global lanes *)modal;
    __global const lanes *own = (__global const lanes *)film->own_share;
    __global const lanes *other = (__global const lanes *)film->other_share;
    FOR_EACH(i, g->count / LANES)
    {
        const lanes values = m[i];
        m[i] = own[i] * values + other[i] * pairs_swapped(values);
    }
    SYNC;
}

/* Solve (D Δ − σ A d/dT) u = modal − σ A dw/dT in place, which is (D Δ − σ A d/dT) (u − w) =
 * modal − D Δ w. */
static void precondition_with_time_term(const Grid *g, const Film *film, constant_vector w, vector modal)
{
    __global lanes *m = (__global lanes *)modal;
    __global const lanes *known = (__global const lanes *)w;
    __global const lanes *diffusion = (__global const lanes *)film->diffusion;
    __global const lanes *own = (__global const lanes *)film->own_share;
    __global const lanes *other = (__global const lanes *)film->other_share;
    FOR_EACH(i, g->count / LANES)
    {
        const lanes values = m[i] - diffusion[i] * known[i];
        m[i] = known[i] + own[i] * values + other[i] * pairs_swapped(values);
    }
    SYNC;
}
#endif

/* r = Σ_k H^(a/2) (Δv − q v), one term: v is given, `work` is overwritten. */
static void add_flow(const Grid *g, const Film *film, int k, field v, field work, field r)
{
    laplacian(g, g->laplace_x, g->laplace_y, v, work);
    matrix4 power = film->gap_power[k], q = film->potential[k];
    matrix4 v4 = (matrix4)v, curvature = (matrix4)work;
    field4 r4 = (field4)r;
    if (k == 0)
        FOR_EACH(i, g->count4) r4[i] = power[i] * (curvature[i] - q[i] * v4[i]);
    else
        FOR_EACH(i, g->count4) r4[i] += power[i] * (curvature[i] - q[i] * v4[i]);
    SYNC;
}

/* v of one flow term, and its response to a mass perturbation; what it adds to the diffusivity. */
static double4 flow_from(const Grid *whole_grid, const Film *whole_film, int k, field4 v)
{
    AS_COPIES(whole_grid, whole_film)
    matrix4 mean_resistance = (matrix4)g->mean_resistance, gap_power = film->gap_power[k];
    const double factor = film->row->flow[k];
    double4 diffusivity = (double4)(0.0);
    FOR_EACH_POINT(g, row, t, i)
    {
        const double4 gap = gap_at(g, film, row, t), p = film->p[i];
        const double4 power = factor * gap_power[i];
        const double4 response = power * flow_slope(film, p, k) / (gap * density_slope(film, p));
        v[i] = power * flow_potential(film, p, k);
        store4(response, i, film->response[k]);
        diffusivity += response * gap_power[i] * mean_resistance[t];
    }
    SYNC;
    return diffusivity;
}

/* r −= σ ∂H/∂T, and the mass that the overpressure adds. */
static void add_squeeze(const Grid *whole_grid, const Film *whole_film, field4 mass, field4 r)
{
    AS_COPIES(whole_grid, whole_film)
    FOR_EACH_POINT(g, row, t, i)
    {
        mass[i] = gap_at(g, film, row, t) * density_rise(film, film->p[i]);
        r[i] -= film->sigma * rate_by(g, film, film->amplitude, row, t);
    }
    SYNC;
}

/* Relative change of the diffusivity up to which a preconditioner stays as it is. */
#define NEAR 0.02

/* Residual of the equation at the state p, in modal coefficients; behind it, preconditioned, those of
 * the terms' own unknowns. Also sets the response of each flow term to a mass perturbation and the
 * mean diffusivity for the Jacobian at this state. */
static void residual(const Grid *g, Film *film, vector modal, __local double *scratch)
{
    field v = film->work_a, work = film->work_b, r = film->work_c;
    field4 v4 = (field4)v, work4 = (field4)work, r4 = (field4)r;
    double4 diffusivity = (double4)(0.0);
    for (int k = 0; k < FLOW_TERMS; k++) {
        diffusivity += flow_from(g, film, k, v4);
        add_flow(g, film, k, v, work, r);
    }
    const double mean_diffusivity = sum_over_group(sum_of(diffusivity), scratch) / g->count;
    add_squeeze(g, film, work4, r4);
    along_t(g, g->time_derivative, work, v, 0);
    subtract(r, film->sigma, v, g->count4);
    film->own_out = modal + g->count;
    TERMS_RESIDUAL(g, film, work, v, r)
    vector nodal = (vector)v;
    FOR_EACH(i, g->count4) store4(r4[i], i, nodal);
    SYNC;
    to_modal(g, nodal, modal);
    if (!(fabs(mean_diffusivity - film->diffusivity) <= NEAR * film->diffusivity)) {
        film->diffusivity = mean_diffusivity;
        set_preconditioner(g, film);
    }
    SYNC;
}

/* out = preconditioned Jacobian times w, both modal, and both with the terms' own unknowns behind. */
static void apply_jacobian(const Grid *g, Film *film, vector w, vector out)
{
    vector v = (vector)film->work_a, work = (vector)film->work_b, r = (vector)film->work_c;
    /* `out` keeps the nodal values of w until the terms are added up. */
    from_modal(g, w, work, out);
    __global const lanes *nodal = (__global const lanes *)out;
    __global lanes *values = (__global lanes *)v, *sum = (__global lanes *)r;
    __global const lanes *curvature = (__global const lanes *)work;
    for (int k = 0; k < FLOW_TERMS; k++) {
        __global const lanes *response = (__global const lanes *)film->response[k];
        __global const lanes *power = (__global const lanes *)film->power[k];
        __global const lanes *bend = (__global const lanes *)film->bend[k];
        FOR_EACH(i, g->count / LANES) values[i] = response[i] * nodal[i];
        SYNC;
        laplacian(g, g->linear.laplace_x, g->linear.laplace_y, v, work);
        if (k == 0)
            FOR_EACH(i, g->count / LANES)
                sum[i] = power[i] * (curvature[i] - bend[i] * values[i]);
        else
            FOR_EACH(i, g->count / LANES)
                sum[i] += power[i] * (curvature[i] - bend[i] * values[i]);
        SYNC;
    }
    film->own_in = w + g->count;
    film->own_out = out + g->count;
    TERMS_RESPONSE(g, film, out, v, r)
    to_modal(g, r, out);
    precondition_with_time_term(g, film, w, out);
}
