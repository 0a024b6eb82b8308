// Formatting of numbers and lengths, and creation of elements.
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹", PREFIXES = { "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M" };

export function number(value, digits = 3) {
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(value)) + 1e-9);
  if (power >= -3 && power < 5) return String(Number(value.toPrecision(digits))).replace("-", "−");
  const raised = String(Math.abs(power)).replace(/\d/g, (digit) => RAISED[digit]);
  return `${Number((value / 10 ** power).toPrecision(digits))} × 10${power < 0 ? "⁻" : ""}${raised}`.replace("-", "−");
}

// format a value with an SI prefix before its unit
export function prefixed(value, unit, digits = 4) {
  const power = value ? Math.floor(Math.log10(Math.abs(value)) / 3 + 1e-9) * 3 : 0, known = Math.max(-12, Math.min(6, power));
  return `${Number((value / 10 ** known).toPrecision(digits))} ${PREFIXES[known]}${unit}`.replace("-", "−");
}

// round down to 1, 2 or 5 times a power of ten
export function round(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return power * [5, 2, 1].find((leading) => leading * power <= length);
}

export function element(kind, properties = {}, ...children) {
  const made = Object.assign(document.createElement(kind), properties);
  made.append(...children);
  return made;
}
