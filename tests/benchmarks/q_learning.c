/* Tabular Q-learning in a world where every move has one outcome: step for step, and draw for draw, what
   course_lib.kernels.q_learning does, written as one would write it in C.

   The numbers come from PCG64 either way: through numpy's own bitgen_t, or, with -DINLINE_PCG64, from the same
   generator written out below. */

#include <stdbool.h>
#include <stdint.h>

typedef struct { /* numpy/random/bitgen.h */
    void *state;
    uint64_t (*next_uint64)(void *);
    uint32_t (*next_uint32)(void *);
    double (*next_double)(void *);
    uint64_t (*next_raw)(void *);
} bitgen;

#ifdef INLINE_PCG64

typedef unsigned __int128 uint128;

typedef struct {
    uint128 state, increment;
} generator;

static inline double draw(generator *g)
{
    const uint128 multiplier = ((uint128)2549297995355413924ULL << 64) | 4865540595714422341ULL;
    g->state = g->state * multiplier + g->increment;
    uint64_t folded = (uint64_t)(g->state >> 64) ^ (uint64_t)g->state;
    unsigned turn = (unsigned)(g->state >> 122);
    uint64_t bits = (folded >> turn) | (folded << (-turn & 63)); /* XSL-RR */
    return (double)(bits >> 11) * (1.0 / 9007199254740992.0);
}

/* words: state high, state low, increment high, increment low */
static generator open_generator(const uint64_t *words)
{
    generator g = {((uint128)words[0] << 64) | words[1], ((uint128)words[2] << 64) | words[3]};
    return g;
}

#else

typedef bitgen generator;

static inline double draw(generator *g)
{
    return g->next_double(g->state);
}

static generator open_generator(const bitgen *numpys)
{
    return *numpys;
}

#endif

void q_learning(double *q_table, int64_t *visits, int64_t num_actions, const int32_t *next_states,
                const double *rewards, const bool *terminal, int64_t start, const void *source, double gamma,
                double alpha, double epsilon, double epsilon_decay, int64_t max_steps, int64_t num_episodes,
                double *returns, int64_t *lengths, bool *terminated)
{
    generator g = open_generator(source);
    for (int64_t episode = 0; episode < num_episodes; episode++) {
        int64_t state = start, step = 0;
        double episode_return = 0.0;
        bool ended = false;
        while (step < max_steps && !ended) {
            const double *row = q_table + state * num_actions;
            int64_t action = 0;
            if (draw(&g) < epsilon) {
                action = (int64_t)(draw(&g) * (double)num_actions);
            } else {
                double best = row[0];
                int64_t ties = 1;
                for (int64_t a = 1; a < num_actions; a++) {
                    if (row[a] > best) {
                        best = row[a];
                        action = a;
                        ties = 1;
                    } else if (row[a] == best) {
                        ties++;
                    }
                }
                if (ties > 1) { /* from the first best action on to the one drawn */
                    int64_t skip = (int64_t)(draw(&g) * (double)ties);
                    while (skip > 0) {
                        action++;
                        if (row[action] == best)
                            skip--;
                    }
                }
            }
            int64_t entry = state * num_actions + action;
            double reward = rewards[entry], target = reward;
            state = next_states[entry];
            ended = terminal[entry];
            visits[entry]++;
            if (!ended) {
                const double *next_row = q_table + state * num_actions;
                double best = next_row[0];
                for (int64_t a = 1; a < num_actions; a++)
                    if (next_row[a] > best)
                        best = next_row[a];
                target += gamma * best;
            }
            q_table[entry] += alpha * (target - q_table[entry]);
            episode_return += reward;
            step++;
        }
        returns[episode] = episode_return;
        lengths[episode] = step;
        terminated[episode] = ended;
        epsilon *= epsilon_decay;
    }
}
