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
 *     Σ_k c_k div(H^(3−k) grad g_k) − σ d(Hρ)/dT − Λ d(Hρ)/dX = 0.
 *
 * Newton's correction is sought as a mass perturbation w = δ(Hρ): the stiff time term then keeps a
 * constant coefficient. GMRES is preconditioned from the left by the inverse of D Δ − σ d/dT −
 * Λ d/dX with the mean diffusivity D, diagonal (BEARING: triangular along x) in a modal basis of
 * space times the real Fourier basis. Its vectors are stored in that basis, where the time term is
 * diagonal too, so that its residual norm estimates the error in w itself.
 */

typedef __global double2 *pair;
typedef __global const double2 *pairs;

/* Sizes and the matrices that all scenes of a batch share. */
typedef struct {
    int nx, ny, nt, rows, count, nt4, row4, count4;
    matrix laplace_x, laplace_y, modes_x, modes_y, to_modes_x, to_modes_y;
    matrix eigenvalues, eigenvalues_y, weights;
    pairs harmonics;
    matrix fourier, fourier_transposed, time_derivative;
    matrix4 sine, cosine;
#ifdef BEARING
    matrix derivative_x, schur;
#endif
} Grid;

/* One scene: its numbers and profile, and the fields of the state that is being improved. */
typedef struct {
    double epsilon, sigma, bearing, inverse_exponent, diffusivity;
    double flow[FLOW_TERMS];
    matrix amplitude, gradient_squared, laplacian, slope_x;
    field4 gap_power[FLOW_TERMS], potential[FLOW_TERMS], response[FLOW_TERMS];
    field4 p;
    field work_a, work_b, work_c;
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
    g.eigenvalues = m; m += nx * ny;
    g.eigenvalues_y = m; m += ny;
    g.weights = m; m += nx * ny;
    g.harmonics = (pairs)m; m += nt;
    g.sine = (matrix4)m; m += nt;
    g.cosine = (matrix4)m; m += nt;
#ifdef BEARING
    g.derivative_x = m;
#endif
    return g;
}

static void along_x(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, g->nx, g->nx, (matrix4)in, (field4)out, g->row4, 1, add);
}

static void along_y(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, g->ny, g->ny, (matrix4)in, (field4)out, g->nt4, g->nx, add);
}

/* out[row][:] = in[row][:] times `transposed` (nt, nt). */
static void along_t(const Grid *g, matrix transposed, field in, field out, int add)
{
    multiply(in, g->rows, g->nt, (matrix4)transposed, (field4)out, g->nt4, 1, add);
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

static double4 gap_at(const Grid *g, const Film *film, int row, int t)
{
    return 1.0 + film->epsilon * film->amplitude[row] * g->sine[t];
}

/* H^(a/2) for a = 3 − k. */
static double4 half_power(double4 gap, int k)
{
    return k == 0 ? gap * sqrt(gap) : k == 1 ? gap : k == 2 ? sqrt(gap) : (double4)(1.0);
}

/* Density ρ(P) − 1 and its derivative; g_k(P) − g_k(1) and its derivative. All exact for small p. */
#ifdef POLYTROPIC
static double4 density_rise(const Film *film, double4 p)
{
    return expm1(film->inverse_exponent * log1p(p));
}
static double4 density_slope(const Film *film, double4 p)
{
    return film->inverse_exponent * exp((film->inverse_exponent - 1.0) * log1p(p));
}
static double4 flow_potential(const Film *film, double4 p, int k)
{
    const double power = (1 - k) * film->inverse_exponent + 1.0;
    return expm1(power * log1p(p)) / power;
}
static double4 flow_slope(const Film *film, double4 p, int k)
{
    return exp((1 - k) * film->inverse_exponent * log1p(p));
}
#else
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
static void set_gap(const Grid *g, Film *film)
{
    for (int k = 0; k < FLOW_TERMS; k++) {
        const double half_exponent = 0.5 * (3 - k);
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = gap_at(g, film, row, t);
            const double4 relative = film->epsilon * g->sine[t] / gap;
            film->gap_power[k][i] = half_power(gap, k);
            film->potential[k][i] =
                half_exponent * relative *
                (film->laplacian[row] +
                 (half_exponent - 1.0) * film->gradient_squared[row] * relative);
        }
    }
    SYNC;
}

/* r = Σ_k H^(a/2) (Δv − q v), one term: v is given, `work` is overwritten. */
static void add_flow(const Grid *g, const Film *film, int k, field v, field work, field r)
{
    along_x(g, g->laplace_x, v, work, 0);
    along_y(g, g->laplace_y, v, work, 1);
    matrix4 power = film->gap_power[k], q = film->potential[k];
    matrix4 v4 = (matrix4)v, curvature = (matrix4)work;
    field4 r4 = (field4)r;
    if (k == 0)
        FOR_EACH(i, g->count4) r4[i] = power[i] * (curvature[i] - q[i] * v4[i]);
    else
        FOR_EACH(i, g->count4) r4[i] += power[i] * (curvature[i] - q[i] * v4[i]);
    SYNC;
}

/* Residual of the equation at the state p, in modal coefficients. Also sets the response of each
 * flow term to a mass perturbation and the mean diffusivity for the Jacobian at this state. */
static void residual(const Grid *g, Film *film, field modal, __local double *scratch)
{
    field v = film->work_a, work = film->work_b, r = film->work_c;
    field4 v4 = (field4)v, work4 = (field4)work, r4 = (field4)r;
    double4 diffusivity = (double4)(0.0);
    for (int k = 0; k < FLOW_TERMS; k++) {
        FOR_EACH_POINT(g, row, t, i)
        {
            const double4 gap = gap_at(g, film, row, t), p = film->p[i];
            const double4 power = film->gap_power[k][i];
            const double4 response = film->flow[k] * power * flow_slope(film, p, k) /
                                     (gap * density_slope(film, p));
            v4[i] = film->flow[k] * power * flow_potential(film, p, k);
            film->response[k][i] = response;
            diffusivity += response * power;
        }
        SYNC;
        add_flow(g, film, k, v, work, r);
    }
    film->diffusivity = sum_over_group(sum_of(diffusivity), scratch) / g->count;
    FOR_EACH_POINT(g, row, t, i)
    {
        work4[i] = gap_at(g, film, row, t) * density_rise(film, film->p[i]);
        r4[i] -= film->sigma * film->epsilon * film->amplitude[row] * g->cosine[t];
#ifdef BEARING
        r4[i] -= film->bearing * film->epsilon * film->slope_x[row] * g->sine[t];
#endif
    }
    SYNC;
    along_t(g, g->time_derivative, work, v, 0);
    subtract(r, film->sigma, v, g->count4);
#ifdef BEARING
    along_x(g, g->derivative_x, work, v, 0);
    subtract(r, film->bearing, v, g->count4);
#endif
    to_modal(g, r, modal);
}

/* Harmonic k has a cosine coefficient c, at k in a row's first half, and a sine coefficient s in
 * its second half: d/dT (c cos kT + s sin kT) = k s cos kT − k c sin kT. The places for k = 0 hold
 * the mean and the last cosine, which both have no rate. Two harmonics are treated at a time. */
#ifdef BEARING
/* modal −= σ dw/dT. */
static void add_time_term(const Grid *g, const Film *film, matrix w, field modal)
{
    const int half_row = g->nt / 4;
    FOR_EACH(row, g->rows)
    {
        pair m = (pair)(modal + row * g->nt);
        pairs from = (pairs)(w + row * g->nt);
        for (int j = 0; j < half_row; j++) {
            const double2 speed = film->sigma * g->harmonics[j];
            m[j] -= speed * from[half_row + j];
            m[half_row + j] += speed * from[j];
        }
    }
    SYNC;
}

/* Solve (D Δ − Λ d/dX − σ d/dT) w = modal in place, in the real Schur basis of the operator along
 * x: back-substitution through the quasi-triangular matrix g->schur, for every mode along y and
 * every harmonic, which is the complex number c − i s here and has the rate i k. */
static void precondition(const Grid *g, const Film *film, field modal)
{
    const int nx = g->nx, stride = g->ny * g->nt, half_row = g->nt / 4;
    matrix triangle = g->schur;
    FOR_EACH(column, g->ny)
    {
        const double shift = film->diffusivity * g->eigenvalues_y[column];
        field m = modal + column * g->nt;
        int top;
        for (int bottom = nx - 1; bottom >= 0; bottom = top - 1) {
            const int coupled = bottom > 0 && triangle[bottom * nx + bottom - 1] != 0.0;
            top = bottom - coupled;
            for (int i = top; i <= bottom; i++)
                for (int j = bottom + 1; j < nx; j++) {
                    const double entry = film->diffusivity * triangle[i * nx + j];
                    field4 to = (field4)(m + i * stride);
                    matrix4 from = (matrix4)(m + j * stride);
                    for (int t = 0; t < g->nt4; t++)
                        to[t] -= entry * from[t];
                }
            const double a = film->diffusivity * triangle[top * nx + top] + shift;
            const double b = film->diffusivity * triangle[top * nx + bottom];
            const double c = film->diffusivity * triangle[bottom * nx + top];
            const double d = film->diffusivity * triangle[bottom * nx + bottom] + shift;
            pair u = (pair)(m + top * stride), v = (pair)(m + bottom * stride);
            for (int j = 0; j < half_row; j++) {
                const double2 speed = film->sigma * g->harmonics[j];
                const double2 u_re = u[j], u_im = -u[half_row + j];
                if (!coupled) {
                    const double2 scale = 1.0 / (a * a + speed * speed);
                    u[j] = scale * (a * u_re - speed * u_im);
                    u[half_row + j] = -scale * (a * u_im + speed * u_re);
                } else {
                    /* (a − iS, b; c, d − iS) by Cramer's rule. */
                    const double2 v_re = v[j], v_im = -v[half_row + j];
                    const double2 det_re = a * d - b * c - speed * speed;
                    const double2 det_im = -speed * (a + d);
                    const double2 scale = 1.0 / (det_re * det_re + det_im * det_im);
                    const double2 top_re = d * u_re + speed * u_im - b * v_re;
                    const double2 top_im = d * u_im - speed * u_re - b * v_im;
                    const double2 low_re = a * v_re + speed * v_im - c * u_re;
                    const double2 low_im = a * v_im - speed * v_re - c * u_im;
                    u[j] = scale * (top_re * det_re + top_im * det_im);
                    v[j] = scale * (low_re * det_re + low_im * det_im);
                    u[half_row + j] = -scale * (top_im * det_re - top_re * det_im);
                    v[half_row + j] = -scale * (low_im * det_re - low_re * det_im);
                }
            }
        }
    }
    SYNC;
}

static void precondition_with_time_term(const Grid *g, const Film *film, matrix w, field modal)
{
    add_time_term(g, film, w, modal);
    precondition(g, film, modal);
}
#else
/* Solve (D Δ − σ d/dT) u = (c, s) for two harmonics of a row: two unknowns by two for each. */
static void solve_harmonics(double diffusion, double2 speed, double2 c, double2 s, pair cosine,
                            pair sine)
{
    const double2 scale = 1.0 / (diffusion * diffusion + speed * speed);
    *cosine = scale * (diffusion * c + speed * s);
    *sine = scale * (diffusion * s - speed * c);
}

/* Solve (D Δ − σ d/dT) u = modal in place. */
static void precondition(const Grid *g, const Film *film, field modal)
{
    const int half_row = g->nt / 4;
    FOR_EACH(row, g->rows)
    {
        const double diffusion = film->diffusivity * g->eigenvalues[row];
        pair m = (pair)(modal + row * g->nt), n = m + half_row;
        for (int j = 0; j < half_row; j++)
            solve_harmonics(diffusion, film->sigma * g->harmonics[j], m[j], n[j], m + j, n + j);
    }
    SYNC;
}

/* Solve (D Δ − σ d/dT) u = modal − σ dw/dT in place, in one pass. */
static void precondition_with_time_term(const Grid *g, const Film *film, matrix w, field modal)
{
    const int half_row = g->nt / 4;
    FOR_EACH(row, g->rows)
    {
        const double diffusion = film->diffusivity * g->eigenvalues[row];
        pair m = (pair)(modal + row * g->nt), n = m + half_row;
        pairs w_cosine = (pairs)(w + row * g->nt), w_sine = w_cosine + half_row;
        for (int j = 0; j < half_row; j++) {
            const double2 speed = film->sigma * g->harmonics[j];
            solve_harmonics(diffusion, speed, m[j] - speed * w_sine[j], n[j] + speed * w_cosine[j],
                            m + j, n + j);
        }
    }
    SYNC;
}
#endif

/* out = preconditioned Jacobian times w, both modal. */
static void apply_jacobian(const Grid *g, const Film *film, field w, field out)
{
    field v = film->work_a, work = film->work_b, r = film->work_c;
    field4 v4 = (field4)v;
    /* `out` keeps the nodal values of w until the terms are added up. */
    from_modal(g, w, work, out);
    matrix4 nodal = (matrix4)out;
    for (int k = 0; k < FLOW_TERMS; k++) {
        matrix4 response = film->response[k];
        FOR_EACH(i, g->count4) v4[i] = response[i] * nodal[i];
        SYNC;
        add_flow(g, film, k, v, work, r);
    }
#ifdef BEARING
    along_x(g, g->derivative_x, out, v, 0);
    subtract(r, film->bearing, v, g->count4);
#endif
    to_modal(g, r, out);
    precondition_with_time_term(g, film, w, out);
}
