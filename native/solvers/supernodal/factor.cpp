// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal/factor.h"

#ifdef SINEW_HAVE_CHOLMOD

#include "native/core/memory.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>

extern "C" {
void dgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
            const int* inner, const double* alpha, const double* a, const int* stride_a, const double* b,
            const int* stride_b, const double* beta, double* c, const int* stride_c);
void dtrsm_(const char* side, const char* triangle, const char* transpose, const char* unit, const int* rows,
            const int* columns, const double* alpha, const double* a, const int* stride_a, double* b,
            const int* stride_b);
void dpotrf_(const char* triangle, const int* size, double* a, const int* stride, int* info);
}

namespace sinew {

namespace {

constexpr int most_parts = 32;
constexpr int panel_width = 96;         ///< columns of a supernode that one thread updates
constexpr int strip_width = 48;         ///< columns of a product
constexpr int panel_height = 256;       ///< rows of a panel's lower part that one thread solves
constexpr double least_parallel = 5e6;  ///< operations; for fewer, one thread is faster
constexpr double least_shared = 2e6;    ///< the same for a single supernode

/// c = alpha a b^T + beta c, with a (rows, inner) and b (columns, inner).
void multiply(int rows, int columns, int inner, double alpha, const double* a, int stride_a, const double* b,
              int stride_b, double beta, double* c, int stride_c)
{
    dgemm_("N", "T", &rows, &columns, &inner, &alpha, a, &stride_a, b, &stride_b, &beta, c, &stride_c);
}

/// b = b L^-T
void divide(int rows, int columns, const double* L, int stride, double* b, int stride_b)
{
    const double one = 1.0;
    dtrsm_("R", "L", "T", "N", &rows, &columns, &one, L, &stride, b, &stride_b);
}

/// The workspace of a thread.
struct Workspace
{
    /// Rows of a product, from `begin` on, that are successive lines of the target, from `line` on.
    struct Run
    {
        int begin, line;
    };
    std::vector<int> place; ///< (size) the line that each row has in the supernode that is being computed
    std::vector<double> product;
    std::vector<Run> runs;
};

class Factorization
{
public:
    Factorization(const SupernodalFactor& factor, const PrincipalBlock& matrix,
                  const std::vector<char>& chosen, bool parallel)
        : f_(factor), matrix_(matrix), chosen_(chosen), parallel_(parallel), tree_(factor),
          position_(f_.size), next_row_(f_.supernodes), sources_(f_.supernodes)
    {
        for (int k = 0; k < f_.size; ++k)
            position_[f_.permutation[k]] = k;
    }

    int run()
    {
        std::vector<double> work = supernodal_work(f_);
        for (int s = 0; s < f_.supernodes; ++s)
            if (!is_chosen(s))
                work[s] = 0;
        SupernodalSplit cut{{{0, f_.supernodes}}, std::vector<char>(f_.supernodes, false)};
        if (parallel_ && std::accumulate(work.begin(), work.end(), 0.0) > least_parallel)
            cut = split(tree_, work, most_parts);

        const int parts = static_cast<int>(cut.parts.size());
        std::vector<int> broken(parts, -1);
        std::vector<std::vector<int>> leftover(parts); // supernodes that contribute to those on top
        each(parts, true, [&](int p) { broken[p] = subtree(cut.parts[p], leftover[p]); });
        for (const int position : broken)
            if (position >= 0)
                return position;
        for (const std::vector<int>& list : leftover)
            for (const int k : list)
                sources_[target(k)].push_back(k);
        for (int s = 0; s < f_.supernodes; ++s)
            if (cut.on_top[s]) {
                const int position = supernode(s, work[s] > least_shared);
                if (position >= 0)
                    return position;
                pass_on(s, nullptr, f_.supernodes);
            }
        return -1;
    }

private:
    bool is_chosen(int s) const { return chosen_.empty() || chosen_[s]; }
    /// The supernode that has the next row of k as a column.
    int target(int k) const { return tree_.owner[f_.rows_of(k)[next_row_[k]]]; }

    static void each(int count, bool parallel, const std::function<void(int)>& task)
    {
        if (parallel && count > 1) {
            parallel_tasks(count, task);
            return;
        }
        for (int k = 0; k < count; ++k)
            task(k);
    }

    int subtree(SupernodalSplit::Part part, std::vector<int>& leftover)
    {
        for (int s = part.begin; s < part.end; ++s) {
            const int position = supernode(s, false);
            if (position >= 0)
                return position;
            pass_on(s, &leftover, part.end);
        }
        return -1;
    }

    /// Registers what has contributed to s, and s itself, as a source of the next supernode that it
    /// contributes to.
    /// \param leftover  gets the sources of supernodes from `end` on.
    void pass_on(int s, std::vector<int>* leftover, int end)
    {
        const auto register_source = [&](int k) {
            if (next_row_[k] == f_.height(k))
                return;
            const int above = target(k);
            (above < end ? sources_[above] : *leftover).push_back(k);
        };
        for (const int k : sources_[s])
            register_source(k);
        sources_[s] = {};
        next_row_[s] = f_.columns(s);
        if (!is_chosen(s)) // skips supernodes that are not computed
            while (next_row_[s] < f_.height(s) && !is_chosen(target(s)))
                ++next_row_[s];
        register_source(s);
    }

    /// Rows [first, last) of source k that are columns of its target.
    struct Source
    {
        int supernode, first, last;
    };

    int supernode(int s, bool parallel)
    {
        if (!is_chosen(s))
            return -1;
        std::vector<int>& list = sources_[s];
        std::sort(list.begin(), list.end()); // the threads add them in any order
        std::vector<Source> sources;
        sources.reserve(list.size());
        for (const int k : list) {
            const int* rows = f_.rows_of(k);
            const int first = next_row_[k];
            const int last =
                static_cast<int>(std::lower_bound(rows + first, rows + f_.height(k), f_.first[s + 1]) - rows);
            sources.push_back({k, first, last});
            next_row_[k] = last;
        }
        const int width = f_.columns(s);
        each((width + panel_width - 1) / panel_width, parallel, [&](int panel) {
            const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
            work->place.resize(f_.size);
            for (int r = 0; r < f_.height(s); ++r)
                work->place[f_.rows_of(s)[r]] = r;
            gather(s, panel * panel_width, std::min((panel + 1) * panel_width, width), sources, *work);
        });
        return factorize_block(s, parallel);
    }

    /// Computes columns [begin, end) of supernode s: those of A, less the contributions of the sources.
    void gather(int s, int begin, int end, const std::vector<Source>& sources, Workspace& work)
    {
        const int height = f_.height(s), first = f_.first[s];
        double* block = f_.block(s);
        for (int c = begin; c < end; ++c) {
            double* column = block + static_cast<std::size_t>(c) * height;
            std::fill_n(column, height, 0.0);
            matrix_.column(f_.permutation[first + c], [&](int unknown, double value) {
                const int row = position_[unknown];
                if (row >= first + c)
                    column[work.place[row]] = value;
            });
        }
        for (const Source& source : sources) {
            const int* rows = f_.rows_of(source.supernode);
            const auto line = [&](int column) {
                return static_cast<int>(
                    std::lower_bound(rows + source.first, rows + source.last, first + column) - rows);
            };
            const int from = begin == 0 ? source.first : line(begin);
            const int to = end == f_.columns(s) ? source.last : line(end);
            if (from < to)
                subtract(s, source.supernode, from, to, work);
        }
    }

    /// block(s) -= L_k(from.., :) L_k(from..to, :)^T. It works in strips, which compute little above the
    /// diagonal.
    void subtract(int s, int k, int from, int to, Workspace& work)
    {
        for (int begin = from; begin < to; begin += strip_width)
            subtract_strip(s, k, begin, std::min(begin + strip_width, to), work);
    }

    void subtract_strip(int s, int k, int from, int to, Workspace& work)
    {
        const int height = f_.height(s), stride = f_.height(k), inner = f_.columns(k);
        const int tall = stride - from, wide = to - from;
        const int* rows = f_.rows_of(k) + from;
        const double* a = f_.block(k) + from;
        double* block = f_.block(s);
        const int line = work.place[rows[0]], column = rows[0] - f_.first[s];
        if (work.place[rows[tall - 1]] - line == tall - 1) { // the rows are successive lines of the target
            multiply(tall, wide, inner, -1.0, a, stride, a, stride, 1.0,
                     block + static_cast<std::size_t>(column) * height + line, height);
            return;
        }
        work.product.resize(std::max(work.product.size(), static_cast<std::size_t>(tall) * wide));
        double* product = work.product.data();
        multiply(tall, wide, inner, 1.0, a, stride, a, stride, 0.0, product, tall);
        work.runs.clear();
        for (int r = 0; r < tall; ++r) {
            const int there = work.place[rows[r]];
            if (work.runs.empty() || work.runs.back().line + r - work.runs.back().begin != there)
                work.runs.push_back({r, there});
        }
        for (int c = 0; c < wide; ++c, product += tall) {
            double* into = block + static_cast<std::size_t>(rows[c] - f_.first[s]) * height;
            for (std::size_t run = 0; run < work.runs.size(); ++run) {
                const auto [begin, there] = work.runs[run];
                const int end = run + 1 < work.runs.size() ? work.runs[run + 1].begin : tall;
                double* to_line = into + there - begin;
                for (int r = std::max(begin, c); r < end; ++r)
                    to_line[r] -= product[r];
            }
        }
    }

    /// Factorises the gathered block as a dense matrix. The panels do not depend on the number of threads.
    int factorize_block(int s, bool parallel)
    {
        const int width = f_.columns(s), height = f_.height(s);
        for (int c = 0; c < width; c += panel_width) {
            const int part = std::min(panel_width, width - c);
            double* corner = f_.block(s) + static_cast<std::size_t>(c) * height + c;
            int info = 0;
            dpotrf_("L", &part, corner, &height, &info);
            if (info != 0)
                return f_.first[s] + c + info - 1;
            const int below = height - c - part, right = width - c - part;
            each((below + panel_height - 1) / panel_height, parallel, [&](int chunk) {
                const int begin = chunk * panel_height;
                divide(std::min(panel_height, below - begin), part, corner, height, corner + part + begin,
                       height);
            });
            each((right + panel_width - 1) / panel_width, parallel, [&](int panel) {
                const int begin = panel * panel_width;
                const double* a = corner + part + begin;
                multiply(below - begin, std::min(panel_width, right - begin), part, -1.0, a, height, a,
                         height, 1.0, corner + static_cast<std::size_t>(part + begin) * height + part + begin,
                         height);
            });
        }
        return -1;
    }

    const SupernodalFactor& f_;
    const PrincipalBlock& matrix_;
    const std::vector<char>& chosen_;
    const bool parallel_;
    const SupernodalTree tree_;
    std::vector<int> position_; ///< (size) the position of each unknown
    std::vector<int> next_row_; ///< the first row of each supernode that no target has used yet
    std::vector<std::vector<int>> sources_; ///< the supernodes that contribute next to each supernode
    Pool<Workspace> workspaces_;
};

} // namespace

std::vector<char> supernodes_above(const SupernodalFactor& factor, const std::vector<int>& positions)
{
    const SupernodalTree tree(factor);
    std::vector<char> chosen(factor.supernodes, false);
    for (const int position : positions)
        for (int s = tree.owner[position]; s >= 0 && !chosen[s]; s = tree.parent[s])
            chosen[s] = true;
    return chosen;
}

std::vector<double> supernodal_work(const SupernodalFactor& factor)
{
    const SupernodalTree tree(factor);
    std::vector<double> work(factor.supernodes, 0.0);
    for (int s = 0; s < factor.supernodes; ++s) {
        const double columns = factor.columns(s), height = factor.height(s);
        work[s] += columns * columns * height; // an estimate, up to a third too high
        const int* rows = factor.rows_of(s);
        for (int r = factor.columns(s); r < factor.height(s); ++r)
            work[tree.owner[rows[r]]] += 2 * columns * (height - r);
    }
    return work;
}

int factorize_supernodal(const SupernodalFactor& factor, const PrincipalBlock& block,
                         const std::vector<char>& chosen, bool parallel)
{
    return Factorization(factor, block, chosen, parallel).run();
}

} // namespace sinew

#endif
