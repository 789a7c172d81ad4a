# The main figure's numbers from a CSV export, in base R: thresholds by eccentricity and the line omega = m e + omega0.
#
#     parafovea export data --format csv --out tables
#     Rscript mar_figure.R tables [mar.pdf]
#
# The same as mar_figure.py, whose first lines say what model and priors these are, and what is compared. Ends with 1 where its medians and the tables' are more than 0.15 posterior standard deviations apart.

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) < 1) stop("usage: Rscript mar_figure.R FOLDER [FIGURE.pdf]")
scale <- qnorm(0.95) - qnorm(0.05)
tolerance_sd <- 0.15
walkers <- 200; burn <- 500; steps <- 2000
set.seed(20121119)
table_of <- function(name) {
  codes <- c(observer = "character", session = "character", study = "character")
  file <- file.path(arguments[1], paste0(name, ".csv"))
  header <- names(read.csv(file, nrows = 1, check.names = FALSE))
  read.csv(file, check.names = FALSE, colClasses = codes[names(codes) %in% header], encoding = "UTF-8")
}
trials <- table_of("trials"); sessions <- table_of("sessions")
fits <- table_of("fits"); limits <- table_of("thresholds")
if (nrow(fits) == 0) stop("fits.csv has no rows: nothing in this export was fitted")

# Two pixels of the display, in degrees, where a ring of this eccentricity leaves it last.
finest_mar <- function(s, eccentricity_deg) {
  d <- s$distance_mm
  gaze <- c(d * tan(c(s$fixation_x_deg, s$fixation_y_deg) * pi / 180), d)
  across <- sqrt(gaze[1]^2 + d^2)
  side <- if (s$fixation_x_deg > 0) -1 else 1
  right <- c(side * d / across, 0, -side * gaze[1] / across)
  e <- eccentricity_deg * pi / 180
  direction <- gaze / sqrt(sum(gaze^2)) * cos(e) + right * sin(e)
  place <- direction * d / direction[3]
  pitch <- max(s$display_width_mm / s$display_width_px, s$display_height_mm / s$display_height_px)
  atan(2 * pitch / sqrt(sum(place^2))) * 180 / pi
}

# Of points x, one a row: locations with a prior of SD 1.5 around the logarithms of `centres`, then ln width, then the lapse rate.
log_posterior <- function(x, ln_threshold, centres, data) {
  p <- ncol(x); locations <- seq_len(p - 2); cells <- nrow(data)
  inside <- x[, p] >= 0 & x[, p] < 0.5
  lapse <- ifelse(inside, x[, p], 0.25)
  each_row <- function(values) matrix(values, nrow(x), cells, byrow = TRUE)
  t <- scale * (each_row(log(data$omega)) - ln_threshold(x)) / exp(x[, p - 1])
  right <- 0.5 + (0.5 - lapse) * pnorm(t)
  wrong <- lapse + (0.5 - lapse) * pnorm(-t)
  k <- each_row(data$k); missed <- each_row(data$n - data$k)
  value <- rowSums(ifelse(k > 0, k * log(right), 0) + ifelse(missed > 0, missed * log(wrong), 0))
  value <- value - 0.5 * rowSums(((x[, locations, drop = FALSE] - rep(log(centres), each = nrow(x))) / 1.5)^2)
  value <- value - 0.5 * ((x[, p - 1] - log(0.8)) / 0.8)^2 + 9 * log1p(-lapse)
  ifelse(inside, value, -Inf)
}

# The maximum; the last parameter is a lapse rate in [0, 0.5).
highest <- function(f, start) {
  best <- NULL
  down <- function(x) min(-f(matrix(x, 1)), 1e9)
  for (lapse in c(0.005, 0.05)) {
    fit <- optim(c(start, lapse), down, method = "L-BFGS-B", lower = c(rep(-12, length(start)), 0),
                 upper = c(rep(6, length(start)), 0.499))
    for (again in 1:3) fit <- optim(fit$par, down, control = list(maxit = 20000, reltol = 1e-13))
    if (is.null(best) || fit$value < best$value) best <- fit
  }
  best$par
}

# Posterior medians by differential evolution (ter Braak 2006): each half of the walkers moves along differences of the other.
medians <- function(f, start) {
  p <- length(start); half <- walkers / 2
  x <- matrix(start, walkers, p, byrow = TRUE) + 0.1 * matrix(rnorm(walkers * p), walkers)
  x[, p] <- pmin(rbeta(walkers, 1, 10), 0.49)
  value <- f(x)
  kept <- array(0, c(steps, walkers, p))
  for (step in seq_len(burn + steps)) {
    for (own in list(1:half, (half + 1):walkers)) {
      other <- setdiff(1:walkers, own)
      gamma <- if (step %% 10 == 0) 1 else 2.38 / sqrt(2 * p)
      along <- x[sample(other, half, TRUE), ] - x[sample(other, half, TRUE), ]
      there <- x[own, ] + gamma * along + 1e-4 * matrix(rnorm(half * p), half)
      value_there <- f(there)
      moved <- log(runif(half)) < value_there - value[own]
      x[own[moved], ] <- there[moved, ]
      value[own[moved]] <- value_there[moved]
    }
    if (step > burn) kept[step - burn, , ] <- x
  }
  apply(kept, 3, median)
}

# Highest point and median of locations, width and lapse, in two columns.
fit <- function(ln_threshold, centres, data, names) {
  f <- function(x) log_posterior(x, ln_threshold, centres, data)
  top <- highest(f, c(log(centres), log(0.8)))
  both <- cbind(top = top, middle = medians(f, top))
  last <- nrow(both)
  both[-last, ] <- exp(both[-last, ])
  rownames(both) <- c(names, "width", "lapse")
  both
}

fit_line <- function(data) {
  fit(function(x) log(outer(exp(x[, 1]), data$e) + exp(x[, 2])), c(0.025, 1 / 48), data, c("m", "omega0"))
}

fit_thresholds <- function(data) {
  rings <- sort(unique(data$e)); ring <- match(data$e, rings)
  fit(function(x) x[, ring, drop = FALSE], 0.025 * rings + 1 / 48, data, as.character(rings))[seq_along(rings), , drop = FALSE]
}

beside <- function(name, own, median, low, high) {
  away <- if (name == "lapse") abs(own[2] - median) / ((high - low) / 3.92) else abs(log(own[2] / median)) / (log(high / low) / 3.92)
  cat(sprintf("  %-8s %10.5f %10.5f %10.5f   %.5f - %.5f   %5.3f SD\n", name, own[1], own[2], median, low, high, away))
  away <= tolerance_sd
}

agree <- TRUE
drawn <- list()
for (key in unique(paste(fits$study, fits$observer, sep = "\t"))) {
  study <- strsplit(key, "\t")[[1]][1]; observer <- strsplit(key, "\t")[[1]][2]
  own_sessions <- sessions[sessions$study == study & sessions$observer == observer, ]
  own <- trials[trials$session %in% own_sessions$session & trials$practice == 0 & trials$outcome == "answered" &
                  !is.na(trials$correct) & !is.na(trials$mar_deg), ]
  counted <- aggregate(cbind(n = 1, k = own$correct), list(e = own$eccentricity_deg, omega = own$mar_deg), sum)
  limit <- sapply(counted$e, function(e) finest_mar(own_sessions[1, ], e))
  data <- counted[counted$omega > limit * (1 + 1e-9), ]
  cat(sprintf("%s, %s: %d trials in %d cells\n", study, observer, as.integer(sum(data$n)), nrow(data)))
  cat("              highest     median  the table    95 % interval      apart\n")
  line <- fit_line(data); points <- fit_thresholds(data)
  for (quantity in c("m", "omega0", "width", "lapse")) {
    row <- fits[fits$study == study & fits$observer == observer & fits$quantity == quantity, ]
    agree <- beside(quantity, line[quantity, ], row$estimate, row$ci95_low, row$ci95_high) && agree
  }
  beyond <- c()
  rows <- limits[limits$study == study & limits$observer == observer, ]
  for (index in seq_len(nrow(rows))) {
    row <- rows[index, ]; name <- paste(format(row$eccentricity_deg), "deg")
    ring <- as.character(row$eccentricity_deg)
    if (row$limited == 1) {
      beyond[ring] <- row$mar_deg
      known <- ring %in% rownames(points)
      agree <- (!known || points[ring, 2] < row$mar_deg) && agree
      here <- if (known) sprintf("; here %.5f", points[ring, 2]) else ""
      cat(sprintf("  %-8s finer than the display can show, %.5f%s\n", name, row$mar_deg, here))
    } else {
      agree <- beside(name, points[ring, ], row$mar_deg, row$ci95_low, row$ci95_high) && agree
    }
  }
  drawn[[paste0(observer, " (", study, ")")]] <- list(line = line, points = points, beyond = beyond)
}

if (length(arguments) > 1) {
  pdf(arguments[2], width = 5, height = 4)
  widest <- max(sapply(drawn, function(d) max(as.numeric(rownames(d$points)))))
  tallest <- max(sapply(drawn, function(d) max(d$points[, 2])))
  plot(NULL, xlim = c(0, widest * 1.1), ylim = c(0, tallest * 1.2), xlab = "eccentricity (deg)",
       ylab = "minimum angle of resolution (deg/cycle)")
  for (index in seq_along(drawn)) {
    abline(drawn[[index]]$line["omega0", 2], drawn[[index]]$line["m", 2], col = index)
    own <- drawn[[index]]$points
    shown <- own[!rownames(own) %in% names(drawn[[index]]$beyond), , drop = FALSE]
    points(as.numeric(rownames(shown)), shown[, 2], col = index, pch = 19)
    # What the display could not show is a limit and no value.
    points(as.numeric(names(drawn[[index]]$beyond)), drawn[[index]]$beyond, col = index, pch = 6)
  }
  legend("topleft", names(drawn), col = seq_along(drawn), pch = 19)
  invisible(dev.off())
}
cat(if (agree) "agree\n" else sprintf("DISAGREE: more than %g posterior standard deviations apart\n", tolerance_sd))
quit(status = if (agree) 0 else 1)
