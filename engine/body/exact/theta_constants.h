#pragma once

namespace stiefel::theta {

/// Where the constants of a ThetaTop stand. A constant of two words takes two places.
enum Place {
  near_separatrix = 0,  ///< 1 or 0: which of the two lists below holds
  turns = 1,            ///< du/dt/4K
  start = 3,            ///< u/4K at time 0
  precession = 5,       ///< dα/dt/2π
  A = 7,                ///< w, a, b, c
  series = 15,

  // Away from the separatrix, polynomials in sin²z. The first `words` coefficients have two words.
  Z_w = series,   ///< Re Z₁
  Z_a = Z_w + 7,  ///< Im Z₁/(sin z cos z)
  Z_b = Z_a + 7,  ///< Re Z₂/cos z
  Z_c = Z_b + 7,  ///< Im Z₂/sin z
  D = Z_c + 7,    ///< |Z|²
  m_a = D + 7,    ///< D m_a
  m_b = m_a + 7,  ///< D m_b/sin z
  m_c = m_b + 7,  ///< D m_c/cos z
  places = m_c + 7,

  // Next to the separatrix, Q = exp(−πK/2K′), y = (π/2K′)(β′/2).
  rate = series,        ///< 2|x| over |u/4K|
  y_turns = rate + 2,   ///< 2y/π
  Q2 = y_turns + 2,     ///< Q²
  cosines = Q2 + 2,     ///< cos (2n+1)y, n = 0 … 3, the first two with two words
  sines = cosines + 6,  ///< sin (2n+1)y
  B = sines + 6,        ///< of m_a, m_b, m_c
};
inline constexpr int words = 2;   ///< coefficients with two words
inline constexpr int degree = 4;  ///< of the polynomials

}  // namespace stiefel::theta
