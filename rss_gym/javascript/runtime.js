// What translated functions call. Names that begin with $ cannot meet those of Python.
const $number = new Float64Array(1), $pattern = new BigInt64Array($number.buffer);

/** The bits of a double, as a signed BigInt. */
const $bits = (x) => { $number[0] = x; return $pattern[0]; };

/** The double that has these bits. */
const $double = (bits) => { $pattern[0] = BigInt.asIntN(64, bits); return $number[0]; };

/** As Python's min and max, which return the first of two that are equal or not numbers. */
const $min = (a, b) => (b < a ? b : a), $max = (a, b) => (b > a ? b : a);

/** Remainder of whole numbers with the sign of the divisor, as Python's. */
const $mod = (a, b) => a - Math.floor(a / b) * b;

const $abs = (a) => (a < 0n ? -a : a);

/** An array that knows its shape, row by row. */
const $shaped = (array, shape) => { array.shape = shape; return array; };

/** Numbers from base 64, as doubles. */
const $unpacked = (text, kind) =>
  Float64Array.from(new kind(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer));
