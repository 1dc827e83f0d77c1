/* Sliding along x: −Λ d(Hρ)/dX. Its operator along x joins the preconditioner, triangular there; not so
 * within an outline, where −Λ J d(Hρ)/dX = −Λ (Re z′ d(Hρ)/dμ − Im z′ d(Hρ)/dν). */

/* out −= Λ d(mass)/dX. */
static void response_bearing(const Grid *g, const Film *film, field mass, field work, field out)
{
#ifdef HAS_outline
    for (int axis = 0; axis < 2; axis++) {
        matrix turn = ON_AXIS(axis, turn);
        along_axis(g, axis, ON_AXIS(axis, derivative), NODES_TO_SLOPES, mass, work, 0);
        FOR_EACH_POINT(g, row, t, i)
            ((field4)out)[i] -= film->row->bearing * turn[row] * ((matrix4)work)[i];
        SYNC;
    }
#else
    multiply(ARRAY(film, derivative_x), g->nx, g->nx, (matrix)mass, work, g->ny * g->nt, 1, 0);
    subtract(out, film->row->bearing, work, g->count4);
#endif
}

/* The same for all of the mass: that of the gap at ambient density is known. */
static void residual_bearing(const Grid *g, const Film *film, field excess, field work, field out)
{
    const double speed = film->row->bearing;
    field4 out4 = (field4)out;
#ifdef HAS_outline
    matrix turn_x = ARRAY(film, turn_x), turn_y = ARRAY(film, turn_y);
    FOR_EACH_POINT(g, row, t, i)
        out4[i] -= speed * (turn_x[row] * beyond_even(g, film, film->slope_x, row, t) +
                            turn_y[row] * beyond_even(g, film, film->slope_y, row, t));
#else
    FOR_EACH_POINT(g, row, t, i) out4[i] -= speed * beyond_even(g, film, film->slope_x, row, t);
#endif
    SYNC;
    response_bearing(g, film, excess, work, out);
}

#ifndef HAS_outline
#define PRECONDITIONER

/* modal −= σ A dw/dT. */
static void add_time_term(const Grid *g, const Film *film, matrix w, field modal)
{
    field4 m = (field4)modal;
    matrix4 from = (matrix4)w;
    FOR_EACH_POINT(g, row, t, i)
    {
        const double2 speed = film->sigma * (double2)(g->speeds[2 * t], g->speeds[2 * t + 1]);
        const double2 decay = film->sigma * (double2)(g->decays[2 * t], g->decays[2 * t + 1]);
        m[i].even -= decay * from[i].even + speed * from[i].odd;
        m[i].odd -= decay * from[i].odd - speed * from[i].even;
    }
    SYNC;
}

/* Nothing is known of it before it is asked. */
static void set_preconditioner(const Grid *g, const Film *film) {}

/* Solve (D Δ − Λ d/dX − σ A d/dT) w = modal in place, in the real Schur basis of the operator along
 * x: back-substitution through a quasi-triangular matrix, for every mode along y and every
 * pair of modes in time, which is the complex number c − i d here and has the rate g + i s. */
static void precondition(const Grid *g, const Film *film, field modal)
{
    const int nx = g->nx, stride = g->ny * g->nt;
    const double diffusivity = diffusivity_of(film, 0);
    matrix triangle = ARRAY(film, triangle);
    FOR_EACH(column, g->ny)
    {
        const double shift = diffusivity * g->eigenvalues_y[column];
        field m = modal + column * g->nt;
        int top;
        for (int bottom = nx - 1; bottom >= 0; bottom = top - 1) {
            const int coupled = bottom > 0 && triangle[bottom * nx + bottom - 1] != 0.0;
            top = bottom - coupled;
            for (int i = top; i <= bottom; i++)
                for (int j = bottom + 1; j < nx; j++) {
                    const double entry = diffusivity * triangle[i * nx + j];
                    field4 to = (field4)(m + i * stride);
                    matrix4 from = (matrix4)(m + j * stride);
                    for (int t = 0; t < g->nt4; t++)
                        to[t] -= entry * from[t];
                }
            const double first = diffusivity * triangle[top * nx + top] + shift;
            const double b = diffusivity * triangle[top * nx + bottom];
            const double c = diffusivity * triangle[bottom * nx + top];
            const double last = diffusivity * triangle[bottom * nx + bottom] + shift;
            field4 u = (field4)(m + top * stride), v = (field4)(m + bottom * stride);
            for (int j = 0; j < g->nt4; j++) {
                const double2 speed = film->sigma * (double2)(g->speeds[2 * j], g->speeds[2 * j + 1]);
                const double2 decay = film->sigma * (double2)(g->decays[2 * j], g->decays[2 * j + 1]);
                const double2 a = first - decay, d = last - decay;
                const double2 u_re = u[j].even, u_im = -u[j].odd;
                if (!coupled) {
                    const double2 scale = 1.0 / (a * a + speed * speed);
                    u[j].even = scale * (a * u_re - speed * u_im);
                    u[j].odd = -scale * (a * u_im + speed * u_re);
                } else {
                    /* (a − iS, b; c, d − iS) by Cramer's rule. */
                    const double2 v_re = v[j].even, v_im = -v[j].odd;
                    const double2 det_re = a * d - b * c - speed * speed;
                    const double2 det_im = -speed * (a + d);
                    const double2 scale = 1.0 / (det_re * det_re + det_im * det_im);
                    const double2 top_re = d * u_re + speed * u_im - b * v_re;
                    const double2 top_im = d * u_im - speed * u_re - b * v_im;
                    const double2 low_re = a * v_re + speed * v_im - c * u_re;
                    const double2 low_im = a * v_im - speed * v_re - c * u_im;
                    u[j].even = scale * (top_re * det_re + top_im * det_im);
                    v[j].even = scale * (low_re * det_re + low_im * det_im);
                    u[j].odd = -scale * (top_im * det_re - top_re * det_im);
                    v[j].odd = -scale * (low_im * det_re - low_re * det_im);
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
#endif
