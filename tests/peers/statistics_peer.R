# Repeated-measures ANOVA by car: Rscript statistics_peer.R VALUES.csv LEVELS_OF_A [LEVELS_OF_B ...]
# One row a subject, the last factor's level changing fastest. Prints term, SS, df, error SS, df, F, p, GG, p, HF, p, W.
suppressPackageStartupMessages(library(car))
arguments <- commandArgs(trailingOnly = TRUE)
values <- as.matrix(read.csv(arguments[1], header = FALSE))
lengths <- as.integer(arguments[-1])
names <- LETTERS[seq_along(lengths)]
idata <- rev(expand.grid(rev(setNames(lapply(lengths, function(n) factor(seq_len(n))), names))))
idata <- idata[names]
options(contrasts = c("contr.sum", "contr.poly"))
fit <- lm(values ~ 1)
design <- as.formula(paste("~", paste(names, collapse = "*")))
found <- suppressWarnings(summary(Anova(fit, idata = idata, idesign = design, type = 3), multivariate = FALSE))
tests <- found$univariate.tests
adjusted <- found$pval.adjustments
sphericity <- found$sphericity.tests
for (term in setdiff(rownames(tests), "(Intercept)")) {
  of <- function(table, column) if (!is.null(table) && term %in% rownames(table)) table[term, column] else NA
  row <- c(tests[term, "Sum Sq"], tests[term, "num Df"], tests[term, "Error SS"], tests[term, "den Df"],
           tests[term, "F value"], tests[term, "Pr(>F)"], of(adjusted, 1), of(adjusted, 2), of(adjusted, 3),
           of(adjusted, 4), of(sphericity, 1))
  # Of one contrast, car has no epsilon and prints p values of 0 beside it.
  if (is.na(row[7])) row[7:11] <- NA
  cat(term, ",", paste(ifelse(is.na(row), "NA", formatC(row, digits = 17, format = "g", width = -1)), collapse = ","), "\n", sep = "")
}
