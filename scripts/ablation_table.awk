# Sums up the outputs of `pled-vins ablate --json` of several recordings, one key a line as it prints
# them: a row for each configuration, with means over the recordings (of ATE the geometric mean, of
# w_ratio the median).
#
#   awk -F'"' -f scripts/ablation_table.awk [-v rows=used] FILE...
BEGIN { if (rows == "") rows = "all" }
function text() { return $4 }
function number(  part) { split($3, part, /[:,]/); return part[2] }
function key() { return method SUBSEP from SUBSEP features }
/"method"/ { method = text() }
/"weights_from"/ { from = text() }
/"features"/ {
  features = text()
  if (!(key() in seen)) { seen[key()] = 1; order[++n] = key() }
}
/"ate_rmse_m":/ {
  if (number() ~ /null/) ++lost[key()]
  else { logs[key()] += log(number()); ++ates[key()]; if (number() + 0 > worst[key()]) worst[key()] = number() + 0 }
}
/"kind"/ { kind = text() }
/"rows"/ { of = text() }
function add(name) { if (number() !~ /null/) { sum[key(), kind, of, name] += number(); ++count[key(), kind, of, name] } }
/"auc"/ { add("auc") }
/"mae_balanced":/ { add("balanced") }
/"w_static"/ { add("static") }
/"w_ratio"/ { if (number() !~ /null/) ratio[key(), kind, of, ++ratios[key(), kind, of]] = number() + 0 }
function mean(k, name) { return count[k, name] ? sprintf("%6.3f", sum[k, name] / count[k, name]) : "     -" }
function middle(k,   i, j, m, v, swap) {
  m = ratios[k]
  if (!m) return "     -"
  for (i = 1; i <= m; ++i) v[i] = ratio[k, i]
  for (i = 1; i <= m; ++i) for (j = i + 1; j <= m; ++j) if (v[j] < v[i]) { swap = v[i]; v[i] = v[j]; v[j] = swap }
  return sprintf("%6.2f", (v[int((m + 1) / 2)] + v[int(m / 2) + 1]) / 2)
}
function quality(k) { return mean(k, "auc") " " mean(k, "balanced") " " middle(k) " " mean(k, "static") }
END {
  printf "%-9s %-19s %-12s | %7s %7s %4s | %-27s | %s\n", "method", "weights from", "features", "ATE mm", "worst", "none", "points: AUC bal. ratio static", "lines: the same (" rows ")"
  for (i = 1; i <= n; ++i) {
    split(order[i], part, SUBSEP)
    k = order[i]
    printf "%-9s %-19s %-12s | %7s %7s %4d | %s | %s\n", part[1], part[2], part[3], \
      ates[k] ? sprintf("%.2f", 1000 * exp(logs[k] / ates[k])) : "-", ates[k] ? sprintf("%.1f", 1000 * worst[k]) : "-", lost[k], \
      quality(k SUBSEP "point" SUBSEP rows), quality(k SUBSEP "line" SUBSEP rows)
  }
}
