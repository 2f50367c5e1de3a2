/* The radio of a tick in C, the yardstick of benchmarks/radio.py: the same arithmetic in the same order as
   rss_gym/physics/random.py, elementary.py, path_loss.py, noise.py and rss_gym/ranging/coloured.py. */
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef uint64_t u64;
typedef int64_t i64;

static const u64 MASK = 0xFFFFFFFFu;

static double of_bits(i64 bits) { double x; memcpy(&x, &bits, 8); return x; }
static i64 to_bits(double x) { i64 bits; memcpy(&bits, &x, 8); return bits; }

static void philox(u64 c0, u64 c1, u64 c2, u64 c3, u64 k0, u64 k1, u64 *out) {
  for (int round = 0; round < 10; round++) {
    u64 p0 = 0xD2511F53u * c0, p1 = 0xCD9E8D57u * c2;
    c0 = (p1 >> 32) ^ c1 ^ k0, c2 = (p0 >> 32) ^ c3 ^ k1, c1 = p1 & MASK, c3 = p0 & MASK;
    k0 = (k0 + 0x9E3779B9u) & MASK, k1 = (k1 + 0xBB67AE85u) & MASK;
  }
  out[0] = c0, out[1] = c1, out[2] = c2, out[3] = c3;
}

static inline double log_parts(double x, double *k, double *f, double *half_square) {
  int subnormal = x < 0x1p-1022;
  i64 bits = to_bits(subnormal ? x * 0x1p54 : x) + (0x3FF0000000000000 - 0x3FE6A09E667F3BCD);
  *k = of_bits((bits >> 52) | 0x4330000000000000) - (0x1p52 + 1023.0 + (subnormal ? 54.0 : 0.0));
  *f = of_bits((bits & 0x000FFFFFFFFFFFFF) + 0x3FE6A09E667F3BCD) - 1.0;
  double s = *f / (2.0 + *f), z = s * s, w = z * z;
  double even = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  double odd = z * (6.666666666666735130e-01 +
                    w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860510658591e-01)));
  *half_square = 0.5 * *f * *f;
  return s * (*half_square + (even + odd));
}

static inline double own_log(double x) {
  double k, f, half_square, tail = log_parts(x, &k, &f, &half_square);
  return k * 6.93147180369123816490e-01 - ((half_square - (tail + k * 1.90821492927058770002e-10)) - f);
}

static inline double own_log10(double x) {
  if (!(0.0 < x && x < INFINITY)) return x == 0.0 ? -INFINITY : x > 0.0 ? x : NAN;
  double k, f, half_square, tail = log_parts(x, &k, &f, &half_square);
  double high = of_bits(to_bits(f - half_square) & -0x100000000);
  double low = ((f - high) - half_square) + tail;
  double product = high * 4.34294481878168880939e-01, whole = k * 3.01029995663611771306e-01;
  double rest = k * 3.69423907715893078616e-13 + (low + high) * 2.50829467116452752298e-11 + low * 4.34294481878168880939e-01;
  double total = whole + product;
  return (rest + ((whole - total) + product)) + total;
}

static double own_exp(double x) {
  double n = (x * 1.44269504088896338700e00 + 0x1.8p52) - 0x1.8p52;
  double high = x - n * 6.93147180369123816490e-01, low = n * 1.90821492927058770002e-10, r = high - low, z = r * r;
  double c = r - z * (1.66666666666666019037e-01 +
                      z * (-2.77777777770155933842e-03 +
                           z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  double y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
  i64 k = (i64)n, half = k >> 1;
  return y * of_bits((half + 1023) << 52) * of_bits((k - half + 1023) << 52);
}

static double unit_uniform(u64 word) { return ((double)word + 0.5) * 0x1p-32; }

/* Ziggurat from its first word on; the tables come from Python. */
static double slow_normal(u64 key, u64 stream, i64 index, i64 w, const double *unit, const i64 *inner, const double *density) {
  const double r = 3.6541528853610088;
  u64 words[4];
  i64 attempt = 0, m;
  for (;;) {
    i64 layer = w & 255;
    m = ((w >> 7) | 1) - (1 << 24);
    double x = (double)m * unit[layer];
    if ((m < 0 ? -m : m) < inner[layer]) return x;
    attempt++;
    philox((u64)(index >> 2) & MASK, stream, 4 * attempt + (index & 3), 0, key & MASK, key >> 32, words);
    if (layer == 0) break;
    double low = density[layer];
    if (low + unit_uniform(words[0]) * (density[layer + 1] - low) < own_exp(-0.5 * x * x)) return x;
    w = (i64)words[2];
  }
  for (;;) {
    double beyond = -own_log(unit_uniform(words[0])) / r;
    if (-2.0 * own_log(unit_uniform(words[1])) >= beyond * beyond) return m > 0 ? r + beyond : -r - beyond;
    attempt++;
    philox((u64)(index >> 2) & MASK, stream, 4 * attempt + (index & 3), 0, key & MASK, key >> 32, words);
  }
}

/* rows x links records of (coloured noise, d, phi, p_dd, p_dp, p_pp); `blocks` blocks of four ticks. */
void radio(i64 rows, i64 links, i64 blocks, const u64 *keys, const double *square, double *state, double *normals,
           const double *channel, const double *unit, const i64 *inner, const double *density) {
  const double gamma = channel[0], offset = channel[1], white_std = channel[2], white_var = channel[3], a = channel[4],
               drive = channel[5], noise = channel[6], floor_m = channel[7], ln10 = 2.302585092994046;
  for (i64 block = 0; block < blocks; block++)
    for (i64 row = 0; row < rows; row++) {
      u64 key = keys[row];
      for (i64 s = 0; s < 2 * links; s++) {
        u64 words[4];
        philox((u64)block & MASK, (u64)s, 0, 0, key & MASK, key >> 32, words);
        for (int j = 0; j < 4; j++) {
          i64 w = (i64)words[j], layer = w & 255, m = ((w >> 7) | 1) - (1 << 24);
          double x = (double)m * unit[layer];
          if ((m < 0 ? -m : m) >= inner[layer]) x = slow_normal(key, (u64)s, 4 * block + j, w, unit, inner, density);
          normals[4 * s + j] = x;
        }
      }
      for (int tick = 0; tick < 4; tick++)
        for (i64 link = 0; link < links; link++) {
          double *c = state + 6 * (row * links + link);
          c[0] = a * c[0] + a * (drive * normals[8 * link + tick]);
          double rss = offset - 5.0 * gamma * own_log10(square[row * links + link]);
          rss += c[0] + white_std * normals[8 * link + 4 + tick];
          double d = c[1], phi = a * c[2], p_dd = c[3] + noise, p_dp = a * c[4], p_pp = a * a * (c[5] + drive * drive);
          double h = -10.0 * gamma / (d * ln10);
          double hat_d = p_dd * h + p_dp, hat_p = p_dp * h + p_pp, variance = h * hat_d + hat_p + white_var;
          double k_d = hat_d / variance, k_p = hat_p / variance;
          double innovation = rss - (offset - 5.0 * gamma * own_log10(d * d) + phi);
          d = d + k_d * innovation, phi = phi + k_p * innovation;
          double i_dd = 1.0 - k_d * h, i_dp = -k_d, i_pd = -k_p * h, i_pp = 1.0 - k_p;
          double m_dd = i_dd * p_dd + i_dp * p_dp, m_dp = i_dd * p_dp + i_dp * p_pp;
          double m_pd = i_pd * p_dd + i_pp * p_dp, m_pp = i_pd * p_dp + i_pp * p_pp;
          c[1] = d > floor_m ? d : floor_m, c[2] = phi;
          c[3] = m_dd * i_dd + m_dp * i_dp + k_d * white_var * k_d;
          c[4] = m_dd * i_pd + m_dp * i_pp + k_d * white_var * k_p;
          c[5] = m_pd * i_pd + m_pp * i_pp + k_p * white_var * k_p;
        }
    }
}
