/* The periodic state of the Reynolds equation by Newton–GMRES, one scene per work-group at a time.
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
 *     Σ_k c_k div(H^(3−k) grad g_k) − σ d(Hρ)/dT − Λ d(Hρ)/dX = 0.
 *
 * Newton's correction is sought as a mass perturbation w = δ(Hρ): the stiff time term then keeps a
 * constant coefficient. GMRES is preconditioned from the left by the inverse of D Δ − σ d/dT −
 * Λ d/dX with the mean diffusivity D, diagonal (BEARING: triangular along x) in a modal basis of
 * space times the real Fourier basis. Its vectors are stored in that basis, where the time term is
 * diagonal too, so that its residual norm estimates the error in w itself.
 */

/* Sizes and the matrices that all scenes of a batch share. */
typedef struct {
    int nx, ny, nt, rows, count, nt4, row4, count4;
    matrix laplace_x, laplace_y, modes_x, modes_y, to_modes_x, to_modes_y;
    matrix eigenvalues_x, eigenvalues_y, weights_x, weights_y;
    matrix fourier, fourier_transposed, time_derivative, sine, cosine;
#ifdef BEARING
    matrix derivative_x, schur;
#endif
} Grid;

/* One scene: its numbers and profile, and the fields of the state that is being improved. */
typedef struct {
    double epsilon, sigma, bearing, inverse_exponent, diffusivity;
    double flow[FLOW_TERMS];
    matrix amplitude, gradient_squared, laplacian, slope_x;
    field gap_power[FLOW_TERMS], potential[FLOW_TERMS], response[FLOW_TERMS];
    field p, work_a, work_b, work_c;
} Film;

static Grid make_grid(int nx, int ny, int nt, matrix m)
{
    Grid g;
    g.nx = nx; g.ny = ny; g.nt = nt;
    g.rows = nx * ny; g.count = nx * ny * nt;
    g.nt4 = nt / 4; g.row4 = ny * nt / 4; g.count4 = g.count / 4;
    g.laplace_x = m; m += nx * nx;
    g.modes_x = m; m += nx * nx;
    g.to_modes_x = m; m += nx * nx;
    g.laplace_y = m; m += ny * ny;
    g.modes_y = m; m += ny * ny;
    g.to_modes_y = m; m += ny * ny;
    g.fourier = m; m += nt * nt;
    g.fourier_transposed = m; m += nt * nt;
    g.time_derivative = m; m += nt * nt;
    g.eigenvalues_x = m; m += nx;
    g.eigenvalues_y = m; m += ny;
    g.weights_x = m; m += nx;
    g.weights_y = m; m += ny;
    g.sine = m; m += nt;
    g.cosine = m; m += nt;
#ifdef BEARING
    g.derivative_x = m;
#endif
    return g;
}

static void along_x(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, 0, g->nx, g->nx, (matrix4)in, 0, (field4)out, 0, g->row4, 1, add);
}

static void along_y(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, 0, g->ny, g->ny, (matrix4)in, g->row4, (field4)out, g->row4, g->nt4, g->nx, add);
}

/* out[row][:] = in[row][:] times `transposed` (nt, nt). */
static void along_t(const Grid *g, matrix transposed, field in, field out, int add)
{
    multiply(in, 0, g->rows, g->nt, (matrix4)transposed, 0, (field4)out, 0, g->nt4, 1, add);
}

/* modal = (to_modes_x ⊗ to_modes_y ⊗ fourier) values; `values` is overwritten. */
static void to_modal(const Grid *g, field values, field modal)
{
    along_t(g, g->fourier_transposed, values, modal, 0);
    along_x(g, g->to_modes_x, modal, values, 0);
    along_y(g, g->to_modes_y, values, modal, 0);
}

/* values = (modes_x ⊗ modes_y ⊗ fourier') modal, by way of `work`. */
static void from_modal(const Grid *g, field modal, field work, field values)
{
    along_x(g, g->modes_x, modal, values, 0);
    along_y(g, g->modes_y, values, work, 0);
    along_t(g, g->fourier, work, values, 0);
}

static double gap_at(const Grid *g, const Film *film, int row, int t)
{
    return 1.0 + film->epsilon * g->sine[t] * film->amplitude[row];
}

/* H^(a/2) for a = 3 − k. */
static double half_power(double gap, int k)
{
    return k == 0 ? gap * sqrt(gap) : k == 1 ? gap : k == 2 ? sqrt(gap) : 1.0;
}

/* Density ρ(P) − 1, its derivative, and g_k(P) − g_k(1), exact for small p too. */
#ifdef POLYTROPIC
static double density_rise(const Film *film, double p)
{
    return expm1(film->inverse_exponent * log1p(p));
}
static double density_slope(const Film *film, double p)
{
    return film->inverse_exponent * exp((film->inverse_exponent - 1.0) * log1p(p));
}
static double flow_potential(const Film *film, double p, int k)
{
    const double power = (1 - k) * film->inverse_exponent + 1.0;
    return expm1(power * log1p(p)) / power;
}
static double flow_slope(const Film *film, double p, int k)
{
    return exp((1 - k) * film->inverse_exponent * log1p(p));
}
#else
static double density_rise(const Film *film, double p) { return p; }
static double density_slope(const Film *film, double p) { return 1.0; }
static double flow_potential(const Film *film, double p, int k)
{
    return k == 0 ? p * (1.0 + 0.5 * p) : k == 1 ? p : k == 2 ? log1p(p) : p / (1.0 + p);
}
static double flow_slope(const Film *film, double p, int k)
{
    const double pressure = 1.0 + p;
    return k == 0 ? pressure : k == 1 ? 1.0 : k == 2 ? 1.0 / pressure : 1.0 / (pressure * pressure);
}
#endif

/* What depends on the gap alone: H^(a/2) and the potential q of each flow term. */
static void set_gap(const Grid *g, Film *film)
{
    for (int k = 0; k < FLOW_TERMS; k++) {
        const double half_exponent = 0.5 * (3 - k);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double excursion = film->epsilon * g->sine[t];
            const double gap = 1.0 + excursion * film->amplitude[row];
            film->gap_power[k][i] = half_power(gap, k);
            film->potential[k][i] =
                half_exponent * excursion *
                (film->laplacian[row] +
                 (half_exponent - 1.0) * excursion * film->gradient_squared[row] / gap) /
                gap;
        }
    }
    SYNC;
}

/* r = Σ_k H^(a/2) (Δv − q v), one term: v is given, `work` is overwritten. */
static void add_flow(const Grid *g, const Film *film, int k, field v, field work, field r)
{
    along_x(g, g->laplace_x, v, work, 0);
    along_y(g, g->laplace_y, v, work, 1);
    matrix power = film->gap_power[k], q = film->potential[k];
    if (k == 0)
        FOR_EACH(i, g->count) r[i] = power[i] * (work[i] - q[i] * v[i]);
    else
        FOR_EACH(i, g->count) r[i] += power[i] * (work[i] - q[i] * v[i]);
    SYNC;
}

/* Residual of the equation at the state p, in modal coefficients. Also sets the response of each
 * flow term to a mass perturbation and the mean diffusivity for the Jacobian at this state. */
static void residual(const Grid *g, Film *film, field modal, __local double *scratch)
{
    field v = film->work_a, work = film->work_b, r = film->work_c;
    double diffusivity = 0.0;
    for (int k = 0; k < FLOW_TERMS; k++) {
        FOR_EACH_POINT(g, row, t, i)
        {
            const double gap = gap_at(g, film, row, t), p = film->p[i];
            const double power = film->gap_power[k][i];
            const double response = film->flow[k] * power * flow_slope(film, p, k) /
                                    (gap * density_slope(film, p));
            v[i] = film->flow[k] * power * flow_potential(film, p, k);
            film->response[k][i] = response;
            diffusivity += response * power;
        }
        SYNC;
        add_flow(g, film, k, v, work, r);
    }
    film->diffusivity = sum_over_group(diffusivity, scratch) / g->count;
    FOR_EACH_POINT(g, row, t, i)
    {
        work[i] = gap_at(g, film, row, t) * density_rise(film, film->p[i]);
        r[i] -= film->sigma * film->epsilon * film->amplitude[row] * g->cosine[t];
#ifdef BEARING
        r[i] -= film->bearing * film->epsilon * film->slope_x[row] * g->sine[t];
#endif
    }
    SYNC;
    along_t(g, g->time_derivative, work, v, 0);
    FOR_EACH(i, g->count) r[i] -= film->sigma * v[i];
    SYNC;
#ifdef BEARING
    along_x(g, g->derivative_x, work, v, 0);
    FOR_EACH(i, g->count) r[i] -= film->bearing * v[i];
    SYNC;
#endif
    to_modal(g, r, modal);
}

/* Add the time term −σ dw/dT, diagonal here: harmonic k has a cosine and a sine coefficient with
 * d/dT (c cos kT + s sin kT) = k s cos kT − k c sin kT. */
static void add_time_term(const Grid *g, const Film *film, matrix w, field modal)
{
    FOR_EACH(row, g->rows)
    {
        field m = modal + row * g->nt;
        matrix from = w + row * g->nt;
        for (int harmonic = 1; harmonic < g->nt / 2; harmonic++) {
            const double speed = film->sigma * harmonic;
            m[2 * harmonic - 1] -= speed * from[2 * harmonic];
            m[2 * harmonic] += speed * from[2 * harmonic - 1];
        }
    }
    SYNC;
}

#ifdef BEARING
/* Solve (D Δ − Λ d/dX − σ d/dT) w = modal in place, in the real Schur basis of the operator along
 * x: back-substitution through the quasi-triangular matrix g->schur, for every mode along y and
 * every harmonic, which is a complex number c − i s here. */
static void precondition(const Grid *g, const Film *film, field modal)
{
    const int nx = g->nx, nt = g->nt, stride = g->ny * nt;
    matrix triangle = g->schur;
    FOR_EACH(column, g->ny)
    {
        const double shift = film->diffusivity * g->eigenvalues_y[column];
        field m = modal + column * nt;
        int top;
        for (int bottom = nx - 1; bottom >= 0; bottom = top - 1) {
            const int paired = bottom > 0 && triangle[bottom * nx + bottom - 1] != 0.0;
            top = bottom - paired;
            for (int i = top; i <= bottom; i++)
                for (int j = bottom + 1; j < nx; j++) {
                    const double entry = film->diffusivity * triangle[i * nx + j];
                    for (int t = 0; t < nt; t++)
                        m[i * stride + t] -= entry * m[j * stride + t];
                }
            const double a = film->diffusivity * triangle[top * nx + top] + shift;
            const double b = film->diffusivity * triangle[top * nx + bottom];
            const double c = film->diffusivity * triangle[bottom * nx + top];
            const double d = film->diffusivity * triangle[bottom * nx + bottom] + shift;
            for (int harmonic = 0; harmonic <= nt / 2; harmonic++) {
                const int real = harmonic == 0 ? 0 : 2 * harmonic - 1;
                const int paired_time = harmonic > 0 && harmonic < nt / 2;
                const double speed = paired_time ? film->sigma * harmonic : 0.0;
                field u = m + top * stride + real, v = m + bottom * stride + real;
                const double2 ru = (double2)(u[0], paired_time ? -u[1] : 0.0);
                if (!paired) {
                    const double scale = 1.0 / (a * a + speed * speed);
                    u[0] = scale * (a * ru.x - speed * ru.y);
                    if (paired_time)
                        u[1] = -scale * (a * ru.y + speed * ru.x);
                } else {
                    /* [a − iS, b; c, d − iS] by Cramer's rule. */
                    const double2 rv = (double2)(v[0], paired_time ? -v[1] : 0.0);
                    const double2 det =
                        (double2)(a * d - b * c - speed * speed, -speed * (a + d));
                    const double2 nu = (double2)(d * ru.x + speed * ru.y - b * rv.x,
                                                 d * ru.y - speed * ru.x - b * rv.y);
                    const double2 nv = (double2)(a * rv.x + speed * rv.y - c * ru.x,
                                                 a * rv.y - speed * rv.x - c * ru.y);
                    const double scale = 1.0 / (det.x * det.x + det.y * det.y);
                    u[0] = scale * (nu.x * det.x + nu.y * det.y);
                    v[0] = scale * (nv.x * det.x + nv.y * det.y);
                    if (paired_time) {
                        u[1] = -scale * (nu.y * det.x - nu.x * det.y);
                        v[1] = -scale * (nv.y * det.x - nv.x * det.y);
                    }
                }
            }
        }
    }
    SYNC;
}
#else
/* Solve (D Δ − σ d/dT) w = modal in place: two by two, or one by one where time has no rate. */
static void precondition(const Grid *g, const Film *film, field modal)
{
    FOR_EACH(row, g->rows)
    {
        const double diffusion =
            film->diffusivity * (g->eigenvalues_x[row / g->ny] + g->eigenvalues_y[row % g->ny]);
        const double inverse = 1.0 / diffusion;
        field m = modal + row * g->nt;
        m[0] *= inverse;
        m[g->nt - 1] *= inverse;
        for (int harmonic = 1; harmonic < g->nt / 2; harmonic++) {
            const double speed = film->sigma * harmonic;
            const double scale = 1.0 / (diffusion * diffusion + speed * speed);
            const double cosine = m[2 * harmonic - 1], sine = m[2 * harmonic];
            m[2 * harmonic - 1] = scale * (diffusion * cosine + speed * sine);
            m[2 * harmonic] = scale * (diffusion * sine - speed * cosine);
        }
    }
    SYNC;
}
#endif

/* out = preconditioned Jacobian times w, both modal. */
static void apply_jacobian(const Grid *g, const Film *film, field w, field out)
{
    field v = film->work_a, work = film->work_b, r = film->work_c;
#if FLOW_TERMS == 1 && !defined(BEARING)
    from_modal(g, w, work, v);
    FOR_EACH(i, g->count) v[i] *= film->response[0][i];
    SYNC;
    add_flow(g, film, 0, v, work, r);
#else
    /* `out` keeps the nodal values of w until the terms are added up. */
    from_modal(g, w, work, out);
    for (int k = 0; k < FLOW_TERMS; k++) {
        FOR_EACH(i, g->count) v[i] = film->response[k][i] * out[i];
        SYNC;
        add_flow(g, film, k, v, work, r);
    }
#ifdef BEARING
    along_x(g, g->derivative_x, out, v, 0);
    FOR_EACH(i, g->count) r[i] -= film->bearing * v[i];
    SYNC;
#endif
#endif
    to_modal(g, r, out);
    add_time_term(g, film, w, out);
    precondition(g, film, out);
}

static double norm(const Grid *g, field a, __local double *scratch)
{
    return sqrt(dot_product((matrix4)a, (matrix4)a, g->count4, scratch) / g->nt);
}

/* GMRES with modified Gram–Schmidt and Givens rotations for (Jacobian) w = −residual, all
 * preconditioned. On entry basis[0] holds the preconditioned residual of norm `beta`; on exit it
 * holds w. Stops at the norm `target` or after `most` steps; an unfinished correction is still a
 * good Newton step. Returns the number of steps. */
static int gmres(const Grid *g, const Film *film, field basis, field small, double beta,
                 double target, int most, __local double *scratch)
{
    const int lead = most + 1;
    field hessenberg = small, right = hessenberg + lead * most, cosines = right + lead,
          sines = cosines + most;
    const double scale = -1.0 / beta;
    FOR_EACH(i, g->count) basis[i] *= scale;
    SYNC;
    double left = beta;
    int steps = 0;
    if (get_local_id(0) == 0)
        right[0] = beta;
    while (steps < most && left > target) {
        field next = basis + (steps + 1) * g->count;
        apply_jacobian(g, film, basis + steps * g->count, next);
        field column = hessenberg + steps * lead;
        for (int j = 0; j <= steps; j++) {
            field4 old = (field4)(basis + j * g->count), new = (field4)next;
            const double overlap = dot_product(old, new, g->count4, scratch) / g->nt;
            FOR_EACH(i, g->count4) new[i] -= overlap * old[i];
            if (get_local_id(0) == 0)
                column[j] = overlap;
            SYNC;
        }
        const double length = norm(g, next, scratch);
        if (length > 0.0) {
            const double inverse = 1.0 / length;
            FOR_EACH(i, g->count) next[i] *= inverse;
        }
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
    FOR_EACH(i, g->count)
    {
        double sum = 0.0;
        for (int j = 0; j < steps; j++)
            sum += right[j] * basis[j * g->count + i];
        basis[i] = sum;
    }
    SYNC;
    return steps;
}

/* Mean overpressure over film and period, in units of ambient pressure. */
static double mean_overpressure(const Grid *g, const Film *film, __local double *scratch)
{
    double sum = 0.0;
    FOR_EACH(row, g->rows)
    {
        double over_period = 0.0;
        for (int t = 0; t < g->nt; t++)
            over_period += film->p[row * g->nt + t];
        sum += g->weights_x[row / g->ny] * g->weights_y[row % g->ny] * over_period;
    }
    return sum_over_group(sum, scratch) / g->nt;
}

/* Largest share of a pressure step that takes at most 9/10 of the pressure anywhere. */
static double safe_share(const Grid *g, const Film *film, field step, __local double *scratch)
{
    double steepest = 0.0;
    FOR_EACH(i, g->count) steepest = fmax(steepest, -step[i] / (1.0 + film->p[i]));
    steepest = max_over_group(steepest, scratch);
    return steepest > 0.9 ? 0.9 / steepest : 1.0;
}

enum { CONVERGED = 0, STALLED = 1, NOT_FINITE = 2 };

/* Work-groups take scenes from a queue until none is left; each has a workspace of its own, and a
 * scene's result does not depend on which group takes it.
 *
 * numbers: per scene epsilon, sigma, bearing, tolerance (of the force, relative), 1/exponent of the
 *          gas, and the flow coefficients c_0 …
 * profile: per scene amplitude, |grad|², Laplacian and (BEARING) x-slope, each (nx, ny).
 * schur:   BEARING, per scene the Schur vectors along x, their inverse and the triangle (nx, nx).
 * state:   per scene p (nx, ny, nt); the first guess on entry.
 * results: per scene mean overpressure, norm of the last residual, largest |p|, smallest P and
 *          smallest P H.
 * counts:  per scene status, Newton steps, Krylov iterations. */
__kernel void periodic_state(const int scenes, const int nx, const int ny, const int nt,
                             const int most_newton, const int most_krylov,
                             matrix matrices, matrix numbers, matrix profile, matrix schur,
                             field state, field results, __global int *counts, field workspace,
                             const ulong workspace_size, __global int *queue,
                             __local double *scratch)
{
    Grid g = make_grid(nx, ny, nt, matrices);
    __local int taken;
    field space = workspace + get_group_id(0) * workspace_size;
    Film film;
    for (int k = 0; k < FLOW_TERMS; k++) {
        film.gap_power[k] = space;
        film.potential[k] = space + g.count;
        film.response[k] = space + 2 * g.count;
        space += 3 * g.count;
    }
    film.work_a = space;
    film.work_b = space + g.count;
    film.work_c = space + 2 * g.count;
    field basis = space + 3 * g.count;
    field small = basis + (most_krylov + 1) * g.count;

    while (true) {
        if (get_local_id(0) == 0)
            taken = atomic_inc(queue);
        SYNC;
        const int scene = taken;
        SYNC;
        if (scene >= scenes)
            break;
        matrix number = numbers + scene * (5 + FLOW_TERMS);
        film.epsilon = number[0];
        film.sigma = number[1];
        film.bearing = number[2];
        const double tolerance = number[3];
        film.inverse_exponent = number[4];
        for (int k = 0; k < FLOW_TERMS; k++)
            film.flow[k] = number[5 + k];
        matrix s = profile + (ulong)scene * PROFILE_FIELDS * g.rows;
        film.amplitude = s;
        film.gradient_squared = s + g.rows;
        film.laplacian = s + 2 * g.rows;
        film.slope_x = s + (PROFILE_FIELDS - 1) * g.rows;
        film.p = state + (ulong)scene * g.count;
#ifdef BEARING
        g.modes_x = schur + (ulong)scene * 3 * nx * nx;
        g.to_modes_x = g.modes_x + nx * nx;
        g.schur = g.to_modes_x + nx * nx;
#endif
        set_gap(&g, &film);

        int status = STALLED, newton = 0, krylov = 0;
        double beta = 0.0, force = mean_overpressure(&g, &film, scratch);
        for (; newton <= most_newton; newton++) {
            residual(&g, &film, basis, scratch);
            precondition(&g, &film, basis);
            beta = norm(&g, basis, scratch);
            if (!isfinite(beta)) {
                status = NOT_FINITE;
                break;
            }
            /* The force answers to an error w with at most its mean, so beta bounds its error. */
            const double goal = tolerance * fabs(force);
            if (beta <= goal || beta == 0.0) {
                status = CONVERGED;
                break;
            }
            if (newton == most_newton)
                break;
            /* Inner accuracy after Eisenstat and Walker: no finer than Newton's own error. */
            const double target = fmax(0.3 * goal, fmin(0.1 * beta, beta * beta));
            krylov += gmres(&g, &film, basis, small, beta, target, most_krylov, scratch);
            field w = film.work_b;
            from_modal(&g, basis, film.work_a, w);
            FOR_EACH_POINT(&g, row, t, i)
                w[i] /= gap_at(&g, &film, row, t) * density_slope(&film, film.p[i]);
            SYNC;
            const double share = safe_share(&g, &film, w, scratch);
            FOR_EACH(i, g.count) film.p[i] += share * w[i];
            SYNC;
            force = mean_overpressure(&g, &film, scratch);
        }
        double most = 0.0, deficit = -INFINITY, thinness = -INFINITY;
        FOR_EACH_POINT(&g, row, t, i)
        {
            const double pressure = 1.0 + film.p[i];
            most = fmax(most, fabs(film.p[i]));
            deficit = fmax(deficit, -pressure);
            thinness = fmax(thinness, -pressure * gap_at(&g, &film, row, t));
        }
        most = max_over_group(most, scratch);
        deficit = max_over_group(deficit, scratch);
        thinness = max_over_group(thinness, scratch);
        if (get_local_id(0) == 0) {
            results[5 * scene] = force;
            results[5 * scene + 1] = beta;
            results[5 * scene + 2] = most;
            results[5 * scene + 3] = -deficit;
            results[5 * scene + 4] = -thinness;
            counts[3 * scene] = status;
            counts[3 * scene + 1] = newton;
            counts[3 * scene + 2] = krylov;
        }
        SYNC;
    }
}
