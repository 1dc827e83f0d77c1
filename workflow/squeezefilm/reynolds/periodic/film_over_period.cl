/* The film over one period: the Reynolds equation collocated in space and time.
 *
 * Unknown: the gauge pressure p = P − 1, zero on the edge. The mass flux is a sum of one or two terms
 * c_k H^a grad g_k with a = 3 − k and dg_k/dP = ρ^(1−k): the viscous flow, and that by slip of a
 * rarefied gas, or as rarefaction_over_period.cl has them. With v = H^(a/2) g each term needs second
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
    return k == 0 ? gap * sqrt(gap) : gap;
}

/* Density ρ(P) − 1 and its derivative; g_k(P) − g_k(1) and its derivative. All exact for small p. */
#ifndef GAS_LAW
static double4 density_rise(const Film *film, double4 p) { return p; }
static double4 density_slope(const Film *film, double4 p) { return (double4)(1.0); }
static double4 flow_potential(const Film *film, double4 p, int k)
{
    return k == 0 ? p * (1.0 + 0.5 * p) : p;
}
static double4 flow_slope(const Film *film, double4 p, int k)
{
    return k == 0 ? 1.0 + p : (double4)(1.0);
}
#endif

/* What depends on the gap alone: H^(a/2) and the potential q of each flow term. */
static void set_gap(const Grid *whole_grid, const Film *whole_film)
{
    AS_COPIES(whole_grid, whole_film)
    for (int k = 0; k < FLOW_TERMS_OF(film); k++) {
        const double half_exponent = 0.5 * (3 - k);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = gap_at(g, film, row, t), over_gap = 1.0 / gap;
            const double4 along_x = beyond_even(g, film, film->slope_x, row, t) * over_gap;
            const double4 along_y = beyond_even(g, film, film->slope_y, row, t) * over_gap;
            const double4 potential =
                half_exponent *
                (beyond_even(g, film, film->laplacian, row, t) * over_gap +
                 (half_exponent - 1.0) * (along_x * along_x + along_y * along_y));
            film->potential[k][i] = potential;
            store4(potential, i, film->bend[k]);
        }
        /* Roots by themselves: they are calls, before which registers are stored. */
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 power = half_power(gap_at(g, film, row, t), k);
            film->gap_power[k][i] = power;
            store4(power, i, film->power[k]);
        }
    }
#if ROW_PARTS
    set_parts(g, film);
#endif
    SYNC;
}

/* A pair of modes in time has its coefficients (c, s) beside each other; the first pair are the mean
 * and the last cosine, which both have no rate. A d/dT maps (c, s) to (g c + k s, g s − k c), with the
 * pair's decay g and speed k; without inertia g = 0, and with the mean gap at rest k counts
 * harmonics. */
#ifndef PRECONDITIONER
/* What solves (D Δ − σ A d/dT) u = (c, s) at this state by each of the diffusivities: two unknowns by
 * two, for each pair. */
static void set_preconditioner(const Grid *whole_grid, const Film *whole_film)
{
    AS_COPIES(whole_grid, whole_film)
    const real sigma = film->sigma;
    FOR_EACH_POINT(g, row, t, i)
    {
        const real decay = g->decays[2 * t], next_decay = g->decays[2 * t + 1];
        const real speed = g->speeds[2 * t], next_speed = g->speeds[2 * t + 1];
        const double eigenvalue = g->eigenvalues[row];
        /* Numbers one by one: Oclgrind does not follow vectors put together of shorter ones. */
        const JOIN(real, 4) turn = sigma * (JOIN(real, 4))(speed, -speed, next_speed, -next_speed);
        const JOIN(real, 4) damping = sigma * (JOIN(real, 4))(decay, decay, next_decay, next_decay);
        for (int which = 0; which < PRECONDITIONERS; which++) {
            const real diffusion = diffusivity_of(film, which) * eigenvalue;
            const JOIN(real, 4) own = diffusion - damping;
            const JOIN(real, 4) scale = 1 / (own * own + turn * turn);
            ((__global JOIN(real, 4) *)film->own_share[which])[i] = scale * own;
            ((__global JOIN(real, 4) *)film->other_share[which])[i] = scale * turn;
            ((__global JOIN(real, 4) *)film->diffusion)[i] = (JOIN(real, 4))(diffusion);
        }
    }
}

/* Solve (D Δ − σ A d/dT) u = modal in place. */
static void precondition(const Grid *g, const Film *film, vector modal)
{
    __global lanes *m = (__global lanes *)modal;
    __global const lanes *own = (__global const lanes *)film->own_share[0];
    __global const lanes *other = (__global const lanes *)film->other_share[0];
    FOR_EACH(i, g->count / LANES)
    {
        const lanes values = m[i];
        lanes answer = own[i] * values + other[i] * pairs_swapped(values);
#if ROW_PARTS > 1
        const lanes more = ((__global const lanes *)film->second)[i];
        answer += ((__global const lanes *)film->own_share[1])[i] * more +
                  ((__global const lanes *)film->other_share[1])[i] * pairs_swapped(more);
#endif
        m[i] = answer;
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
    __global const lanes *own = (__global const lanes *)film->own_share[0];
    __global const lanes *other = (__global const lanes *)film->other_share[0];
    FOR_EACH(i, g->count / LANES)
    {
        const lanes values = m[i] - diffusion[i] * known[i];
        m[i] = known[i] + own[i] * values + other[i] * pairs_swapped(values);
    }
    SYNC;
}
#endif

/* What answers to rows on nodes and in modes in time, modal and in their place; the second part of them
 * lies in film->second, if there is one. `work` is overwritten. */
static void solve_rows(const Grid *g, const Film *film, vector work, vector modal)
{
    to_modes_in_space(g, work, modal);
#if ROW_PARTS > 1
    to_modes_in_space(g, work, film->second);
#endif
    precondition(g, film, modal);
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
        double4 potential = flow_potential(film, p, k), slope = flow_slope(film, p, k);
#ifdef HAS_flow_factor
        if (film->row->has_flow_factor)
            set_rarefied(film, gap, p, k, i, &potential, &slope);
#endif
        const double4 response = power * slope / (gap * density_slope(film, p));
        v[i] = power * potential;
        store4(response, i, film->response[k]);
        diffusivity +=
            response * gap_power[i] * mean_resistance[t] * over_rest_squared(film, i);
    }
    SYNC;
    return diffusivity;
}

/* r = Σ_k H^(a/2) (Δv − q v) − σ ∂H/∂T, one term: v is given, `work` is overwritten. The last leaves
 * in v's place the mass that the gauge pressure adds. */
static void add_flow(const Grid *whole_grid, const Film *whole_film, int k, field v, field work, field r)
{
    AS_COPIES(whole_grid, whole_film)
    laplacian(g, g->laplace_x, g->laplace_y, v, work);
    matrix4 power = film->gap_power[k], q = film->potential[k], curvature = (matrix4)work;
    field4 v4 = (field4)v, r4 = (field4)r;
    FOR_EACH_POINT(g, row, t, i)
    {
        const double4 before =
            k == 0 ? -film->sigma * rate_by(g, film, film->amplitude, row, t) : r4[i];
        r4[i] = before + power[i] * (curvature[i] - q[i] * v4[i]);
        if (k == FLOW_TERMS_OF(film) - 1)
            v4[i] = gap_at(g, film, row, t) * density_rise(film, film->p[i]);
    }
    SYNC;
}

/* Relative change of the diffusivity up to which a preconditioner stays as it is. */
#define NEAR 0.02

/* Preconditioned residual of the equation at the state p, in modal coefficients; behind it those of the
 * terms' own unknowns. Also sets the response of each flow term to a mass perturbation and the
 * mean diffusivity for the Jacobian at this state. */
static void residual(const Grid *g, Film *film, vector modal, __local double *scratch)
{
    field v = film->work_a, work = film->work_b, r = film->work_c;
    double4 diffusivity = (double4)(0.0);
    for (int k = 0; k < FLOW_TERMS_OF(film); k++) {
        diffusivity += flow_from(g, film, k, (field4)v);
        add_flow(g, film, k, v, work, r);
    }
    const double mean_diffusivity = sum_over_group(sum_of(diffusivity), scratch) / g->count;
    film->own_out = modal + g->count;
    TERMS_RESIDUAL(g, film, v, work, r)
    along_t(g, g->time_derivative, v, work, 0);
    vector nodal = (vector)v;
    const double sigma = film->sigma;
    FOR_EACH(i, g->count4) store4(((matrix4)r)[i] - sigma * ((matrix4)work)[i], i, nodal);
    SYNC;
    to_modes_in_time(g, nodal, modal);
    if (!(fabs(mean_diffusivity - film->diffusivity) <= NEAR * film->diffusivity)) {
        film->diffusivity = mean_diffusivity;
        set_preconditioner(g, film);
    }
    SYNC;
#if ROW_PARTS
    part_rows(g, film, modal, 0);
#endif
    solve_rows(g, film, nodal, modal);
}

/* out = preconditioned Jacobian times w, both modal, and both with the terms' own unknowns behind. */
static void apply_jacobian(const Grid *g, Film *film, vector w, vector out)
{
    vector v = (vector)film->work_a, work = (vector)film->work_b, r = (vector)film->work_c;
#ifdef SINGLE
    vector on_nodes = film->nodal + (w - film->basis) / g->length * g->count;
#else
    vector on_nodes = out; /* until the terms are added up */
#endif
    from_modal(g, w, film->in_time, on_nodes);
    __global const lanes *nodal = (__global const lanes *)on_nodes;
    __global lanes *values = (__global lanes *)v, *sum = (__global lanes *)r;
    __global const lanes *curvature = (__global const lanes *)work;
    for (int k = 0; k < FLOW_TERMS_OF(film); k++) {
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
    TERMS_RESPONSE(g, film, on_nodes, v, r)
    to_modes_in_time(g, r, out);
#if ROW_PARTS
    part_rows(g, film, out, film->in_time);
    solve_rows(g, film, r, out);
#else
    to_modes_in_space(g, r, out);
    precondition_with_time_term(g, film, w, out);
#endif
}
