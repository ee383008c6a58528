// Fields at the nodes of a part at any position of a cycle, superposed anew at every call.
//
// A field over the cycle ("mises", "principal", "displacement") is a sum of the part's fields times
// weights (viewer.js says which); one over the duty ("utilisation", "amplitude", "mean") stands in
// the page as it is. "static" and "column" are "mises" over what these checks allow. Positions are
// those of the whole cycle and may lie between two.

const {
  FIELDS, SHARES, isConstant, hasField, whyNot, fieldValues,
  displacementAt, stressAt, misesOf, principalsOf,
} = (() => {
  const FIELDS = [
    "mises", "principal", "utilisation", "static", "column", "amplitude", "mean", "displacement",
  ];
  const SHARES = { static: "allowed", column: "column" }; // of "mises" over a limit
  const OVER_DUTY = new Set(["utilisation", "amplitude", "mean"]);
  const ALIKE = 1 - 1e-6; // of sizes that differ by round-off the one in tension is told
  const THIRD_TURN = (2 * Math.PI) / 3;

  function isConstant(field) {
    return OVER_DUTY.has(field);
  }

  function hasField(part, field) {
    if (isConstant(field)) return field in part.over;
    return groupOf(part, field) !== undefined &&
      (!(field in SHARES) || part.head.limits?.[SHARES[field]] > 0);
  }

  // Why a part has not a field, in words; "" if it has.
  function whyNot(part, field) {
    if (hasField(part, field)) return "";
    return part.head.missing[field] || "this field is not known of this part";
  }

  function groupOf(part, field) {
    return field === "displacement" ? part.displacement : part.stress;
  }

  // The field at the nodes into `out` (n), its extremes, and the node of the largest size; null
  // where there is none, or the cycle does not load the part.
  function fieldValues(part, cycle, index, field, out) {
    let sums = null;
    if (isConstant(field)) {
      if (field in part.over) out.set(part.over[field]);
      else return emptied(out);
    } else {
      sums = superposed(part, groupOf(part, field), cycle, index);
      if (sums === null) return emptied(out);
      if (field in SHARES) {
        const allowed = part.head.limits[SHARES[field]];
        MEASURES.mises(sums, out);
        for (let i = 0; i < out.length; i += 1) out[i] /= allowed;
      } else MEASURES[field](sums, out);
    }
    const { from, to } = part.head.scale[field];
    return { ...extremes(out), from, to };
  }

  // Displacements into `out` (3 n), x y z of each node, mm; the largest length, or null.
  function displacementAt(part, cycle, index, out) {
    const sums = superposed(part, part.displacement, cycle, index);
    if (sums === null) return emptied(out);
    const [x, y, z] = sums;
    let largest = 0;
    for (let i = 0; i < x.length; i += 1) {
      out[3 * i] = x[i];
      out[3 * i + 1] = y[i];
      out[3 * i + 2] = z[i];
      const square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
      if (square > largest) largest = square;
    }
    return Math.sqrt(largest);
  }

  // Stress at one node: xx, yy, zz, xy, yz, zx, MPa; null where it is not known.
  function stressAt(part, cycle, index, node, out = new Float64Array(6)) {
    const weights = weightsAt(part, part.stress, cycle, index);
    if (weights === null) return null;
    const { fields, worth } = part.stress;
    out.fill(0);
    for (let k = 0; k < fields.length; k += 1) {
      if (fields[k] === null) continue;
      out[k % 6] += weights[Math.floor(k / 6)] * worth[k % 6] * fields[k][node];
    }
    return out;
  }

  function misesOf([xx, yy, zz, xy, yz, zx]) {
    const normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2;
    return Math.sqrt(normal / 2 + 3 * (xy * xy + yz * yz + zx * zx));
  }

  // The principal stresses, the largest first (the roots of the deviator's cubic, by its angle).
  function principalsOf([xx, yy, zz, xy, yz, zx]) {
    const mean = (xx + yy + zz) / 3;
    const [a, b, c] = [xx - mean, yy - mean, zz - mean];
    const shear = xy * xy + yz * yz + zx * zx;
    const radius = Math.sqrt((a * a + b * b + c * c + 2 * shear) / 6);
    if (radius === 0) return [mean, mean, mean];
    const third = a * b * c + 2 * xy * yz * zx - a * yz * yz - b * zx * zx - c * xy * xy;
    const cosine = third / (2 * radius * radius * radius);
    const angle = Math.acos(Math.min(1, Math.max(-1, cosine))) / 3;
    return [
      mean + 2 * radius * Math.cos(angle),
      mean + 2 * radius * Math.cos(angle - THIRD_TURN),
      mean + 2 * radius * Math.cos(angle + THIRD_TURN),
    ];
  }

  const MEASURES = {
    mises([xx, yy, zz, xy, yz, zx], out) {
      for (let i = 0; i < out.length; i += 1) {
        const [a, b, c] = [xx[i] - yy[i], yy[i] - zz[i], zz[i] - xx[i]];
        const shear = xy[i] * xy[i] + yz[i] * yz[i] + zx[i] * zx[i];
        out[i] = Math.sqrt((a * a + b * b + c * c) / 2 + 3 * shear);
      }
    },
    // The principal stress of the largest size, with its sign.
    principal([xx, yy, zz, xy, yz, zx], out) {
      for (let i = 0; i < out.length; i += 1) {
        const mean = (xx[i] + yy[i] + zz[i]) / 3;
        const [a, b, c] = [xx[i] - mean, yy[i] - mean, zz[i] - mean];
        const [p, q, r] = [xy[i], yz[i], zx[i]];
        const square = (a * a + b * b + c * c + 2 * (p * p + q * q + r * r)) / 6;
        const radius = Math.sqrt(square);
        if (radius === 0) {
          out[i] = mean;
          continue;
        }
        const third = a * b * c + 2 * p * q * r - a * q * q - b * r * r - c * p * p;
        const cosine = third / (2 * square * radius);
        const along = Math.cos(Math.acos(cosine > 1 ? 1 : cosine < -1 ? -1 : cosine) / 3);
        const high = mean + 2 * radius * along;
        // the cosine a third of a turn on, its angle being below a sixth
        const low = mean - radius * (along + Math.sqrt(3 * (1 - along * along)));
        out[i] = high >= -low * ALIKE ? high : low;
      }
    },
    displacement([x, y, z], out) {
      for (let i = 0; i < out.length; i += 1) {
        out[i] = Math.sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
      }
    },
  };

  // Sums of a group's fields at a position, an array per component, until another is asked for.
  function superposed(part, group, cycle, index) {
    const weights = weightsAt(part, group, cycle, index);
    if (weights === null) return null;
    const { components, fields, worth } = group;
    if (group.sums === undefined) {
      group.sums = worth.map(() => new Float64Array(part.n));
      group.at = "";
    }
    const at = `${cycle} ${index}`;
    if (group.at === at) return group.sums;
    group.at = at;
    for (let component = 0; component < components; component += 1) {
      const used = [];
      for (let field = 0; field < weights.length; field += 1) {
        const numbers = fields[components * field + component];
        const weight = weights[field] * worth[component];
        if (numbers !== null && weight !== 0) used.push([weight, numbers]);
      }
      const sum = group.sums[component];
      sum.fill(0);
      while (used.length % 4 !== 0) used.push([0, used[0][1]]);
      for (let k = 0; k < used.length; k += 4) addFour(sum, used.slice(k, k + 4));
    }
    return group.sums;
  }

  // Four at a time take little more than half of what one after the other would.
  function addFour(sum, [[p, a], [q, b], [r, c], [s, d]]) {
    for (let i = 0; i < sum.length; i += 1) {
      sum[i] += p * a[i] + q * b[i] + r * c[i] + s * d[i];
    }
  }

  // Weights of a group's fields at a position, on the straight line between the kept ones.
  function weightsAt(part, group, cycle, index) {
    const kept = part.head.cycles[cycle];
    if (group === undefined || !kept) return null;
    const row = rowIn(kept.positions, index);
    return group.weights[cycle].map((weights) => atRow(weights, row));
  }

  function extremes(values) {
    let min = values[0];
    let max = values[0];
    let [lowest, highest] = [0, 0];
    for (let i = 1; i < values.length; i += 1) {
      if (values[i] > max) {
        max = values[i];
        highest = i;
      } else if (values[i] < min) {
        min = values[i];
        lowest = i;
      }
    }
    const up = max >= -min * ALIKE;
    return { min, max, peak: up ? max : min, node: up ? highest : lowest };
  }

  function emptied(out) {
    out.fill(0);
    return null;
  }

  return {
    FIELDS, SHARES, isConstant, hasField, whyNot, fieldValues,
    displacementAt, stressAt, misesOf, principalsOf,
  };
})();
