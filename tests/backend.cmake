# Whole flights, slow under the sanitizers.
pled_add_tests(test_backend TIMEOUT 1500
  SOURCES
    law/backend/calibration_test.cpp
    law/backend/consistency_test.cpp
    law/backend/feature_noise_test.cpp
    law/backend/residual_test.cpp
    law/backend/window_test.cpp
    law/backend/solver_test.cpp
    support/flown_window.cpp
    support/simulated_run.cpp
    unit/backend/backend_test.cpp
  DEPS pled::backend pled::backend_solver pled::consistency)

pled_add_tests(test_backend_law LABEL law
  SOURCES law/backend/adaptive_fusion_test.cpp
          law/backend/arrival_check_test.cpp
          law/backend/feature_loss_test.cpp
          law/backend/line_book_test.cpp
          law/backend/line_residual_test.cpp
          law/backend/robust_weight_test.cpp
  DEPS pled::backend)

# Prints the mean NEES over simulated runs; exit 1 when it lies outside its bounds.
add_test(NAME backend_consistency_50_runs
         COMMAND pled-vins check-consistency --runs 50 --seconds 10)
set_tests_properties(backend_consistency_50_runs PROPERTIES LABELS long TIMEOUT 3000)
